#include "fos_nanoapp_host.h"

#include <chre.h>

/* Messages of telemetry are filled as far as the host takes them; beyond this they would only take memory. */
#ifndef FOS_NANOAPP_FRAMES_BYTES
#define FOS_NANOAPP_FRAMES_BYTES (CHRE_MESSAGE_TO_HOST_MAX_SIZE < 2048 ? CHRE_MESSAGE_TO_HOST_MAX_SIZE : 2048)
#endif

/*
 * A batch of 0.2 s is some 3 KiB of frames. The transport gives buffers back after the event that filled them; when
 * none is free what was to be sent is lost, and counted. Nothing waits.
 */
enum { FRAMES_MESSAGES = 4, SMALL_MESSAGES = 8, SMALL_BYTES = 48 };

typedef char bias_fits[FOS_MESSAGE_BIAS_BYTES <= SMALL_BYTES ? 1 : -1];
typedef char answer_fits[FOS_MESSAGE_ANSWER_BYTES <= SMALL_BYTES ? 1 : -1];
typedef char every_frame_fits[FOS_TELEMETRY_BYTES <= FOS_NANOAPP_FRAMES_BYTES ? 1 : -1];

/* The bytes stand first: the transport gives back their address. */
typedef struct frames_message {
    uint8_t bytes[FOS_NANOAPP_FRAMES_BYTES];
    bool is_taken;
} frames_message;

typedef struct small_message {
    uint8_t bytes[SMALL_BYTES];
    bool is_taken;
} small_message;

static frames_message frames_messages[FRAMES_MESSAGES];
static small_message small_messages[SMALL_MESSAGES];
static frames_message *filling; /* taken, and not sent yet */
static size_t filled;
static uint32_t lost;

static void free_frames(void *bytes, size_t length)
{
    (void)length;
    ((frames_message *)bytes)->is_taken = false;
}

static void free_small(void *bytes, size_t length)
{
    (void)length;
    ((small_message *)bytes)->is_taken = false;
}

static uint8_t *take_small(void)
{
    for (int k = 0; k < SMALL_MESSAGES; k++) {
        if (!small_messages[k].is_taken) {
            small_messages[k].is_taken = true;
            return small_messages[k].bytes;
        }
    }
    lost++;
    return NULL;
}

/* The buffer belongs to the transport from here on, also where it does not take the message. */
static bool send(void *bytes, size_t length, uint32_t type, uint16_t endpoint, chreMessageFreeFunction *give_back)
{
    bool sent = chreSendMessageToHostEndpoint(bytes, length, type, endpoint, give_back);
    if (!sent)
        lost++;
    return sent;
}

void fos_host_start(void)
{
    if (filling != NULL)
        filling->is_taken = false;
    filling = NULL;
    filled = 0;
    lost = 0;
}

void fos_host_answer(uint32_t command, fos_status status, const fos_report *report, uint16_t endpoint)
{
    uint8_t *bytes = take_small();
    if (bytes == NULL)
        return;
    const uint32_t numbers[] = {
        command,          (uint32_t)status,         FOS_NANOAPP_VERSION, report->image_bytes,
        report->image_checksum, report->gyro_interval_ns, report->rows,  report->readings_refused,
        lost,             report->models_taken,     report->models_refused, report->sensors,
    };
    uint8_t *to = bytes;
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
        to = fos_message_put(to, numbers[k], 4);
    send(bytes, FOS_MESSAGE_ANSWER_BYTES, FOS_MESSAGE_ANSWER, endpoint, free_small);
}

bool fos_host_bias(int64_t stamp_ns, const fos_si_output *output)
{
    uint8_t *bytes = take_small();
    if (bytes == NULL)
        return false;
    uint8_t *to = fos_message_put(bytes, (uint64_t)stamp_ns, 8);
    for (int axis = 0; axis < FOS_AXES; axis++)
        to = fos_message_put_float(to, output->predicted[axis]);
    for (int axis = 0; axis < FOS_AXES; axis++)
        to = fos_message_put(to, output->output.validity[axis], 2);
    to = fos_message_put(to, output->output.faults, 2);
    to = fos_message_put(to, output->output.still, 1);
    fos_message_put(to, output->output.drift, 1);
    return send(bytes, FOS_MESSAGE_BIAS_BYTES, FOS_MESSAGE_BIAS, CHRE_HOST_ENDPOINT_BROADCAST, free_small);
}

void fos_host_send_frames(uint16_t endpoint)
{
    frames_message *message = filling;
    filling = NULL;
    if (message == NULL)
        return;
    if (filled == 0)
        message->is_taken = false;
    else
        send(message->bytes, filled, FOS_MESSAGE_FRAMES, endpoint, free_frames);
    filled = 0;
}

/* One frame into the message that is filled, or into the next if it does not fit. */
static bool append(const fos_hub *hub, const uint8_t *image, size_t length, bool start, uint16_t endpoint)
{
    for (int attempt = 0; attempt < 2; attempt++) {
        for (int k = 0; filling == NULL && k < FRAMES_MESSAGES; k++) {
            if (!frames_messages[k].is_taken) {
                filling = &frames_messages[k];
                filling->is_taken = true;
                filled = 0;
            }
        }
        if (filling == NULL)
            break;
        uint8_t *to = filling->bytes + filled;
        size_t room = sizeof filling->bytes - filled, used = 0;
        fos_status status = start ? fos_telemetry_start(hub, image, length, to, room, &used)
                                  : fos_telemetry_sample(hub, to, room, &used);
        if (status == FOS_STATUS_OK) {
            filled += used;
            return true;
        }
        if (status != FOS_STATUS_NO_ROOM || filled == 0)
            break;
        fos_host_send_frames(endpoint);
    }
    lost++;
    return false;
}

bool fos_host_frames(const fos_hub *hub, const uint8_t *image, size_t length, bool begin, uint16_t endpoint)
{
    if (begin && !append(hub, image, length, true, endpoint))
        return false; /* samples without it cannot be read */
    return append(hub, NULL, 0, false, endpoint);
}
