/*
 * The nanoapp's side of the messages: buffers that the transport gives back, and what is put into them.
 */
#ifndef FOS_NANOAPP_HOST_H
#define FOS_NANOAPP_HOST_H

#include <stdbool.h>

#include "fos.h"
#include "fos_nanoapp_messages.h"

/* What every answer says beside the status. */
typedef struct fos_report {
    uint32_t image_bytes;
    uint32_t image_checksum;
    uint32_t gyro_interval_ns;
    uint32_t rows;
    uint32_t readings_refused;
    uint32_t models_taken;
    uint32_t models_refused;
    uint32_t sensors;
} fos_report;

/* Forgets what was lost and what is being filled; buffers under way stay with the transport. */
void fos_host_start(void);

/* Sends an answer to `endpoint`. */
void fos_host_answer(uint32_t command, fos_status status, const fos_report *report, uint16_t endpoint);

/* Sends the bias to everybody who listens; false if it was lost. */
bool fos_host_bias(int64_t stamp_ns, const fos_si_output *output);

/* Appends the frame of the hub's latest sample, before it the frame that says what samples hold if `begin`. False if it
   was lost. */
bool fos_host_frames(const fos_hub *hub, const uint8_t *image, size_t length, bool begin, uint16_t endpoint);

/* Sends the frames that are gathered. */
void fos_host_send_frames(uint16_t endpoint);

#endif
