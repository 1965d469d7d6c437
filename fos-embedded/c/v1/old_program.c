/*
 * old_program IMAGE LOG: a program of the interface's version 1, which is compiled with its header (tests/fixtures/c_api_v1.h) and with
 * today's, and linked with today's archive: both print the same.
 *
 * It prints digests (CRC-32) of what comes out of a log of raw codes, and of the telemetry.
 */
#include <stdio.h>
#include <string.h>

#include "fos.h"

enum { HEADER = 32, RECORD = 32, MAX_IMAGE = 32768 };

/* exactly as large as version 1 said, with what must not be touched behind it */
static struct {
    uint64_t hub[FOS_HUB_BYTES / 8];
    uint64_t guard[8];
} memory;
static struct {
    fos_output output;
    uint8_t guard[32];
} place;
static uint8_t image[MAX_IMAGE], record[RECORD + 4 * UINT8_MAX], frame[FOS_TELEMETRY_BYTES];
static uint32_t crc_of_outputs = UINT32_MAX, crc_of_telemetry = UINT32_MAX;
static unsigned long statuses[64];

static void digest(uint32_t *crc, const void *start, size_t length)
{
    const uint8_t *bytes = start;
    while (length-- > 0) {
        *crc ^= *bytes++;
        for (int bit = 0; bit < 8; bit++)
            *crc = *crc >> 1 ^ (*crc & 1 ? UINT32_C(0xedb88320) : 0);
    }
}

static int count(fos_status status)
{
    statuses[(unsigned)status % 64]++;
    return status == FOS_STATUS_OK;
}

/* The log is little-endian, and so is whatever this runs on. */
static void step(fos_hub *hub, size_t n_given)
{
    fos_raw_sample raw;
    fos_motion motion = record[6];
    uint64_t clock_us;
    size_t used = 0;
    memset(&raw, 0, sizeof raw);
    memcpy(&raw.skipped, record, 4);
    memcpy(&raw.faults, record + 4, 2);
    memcpy(&clock_us, record + 8, 8);
    memcpy(raw.accel, record + 16, 6);
    memcpy(raw.gyro, record + 22, 6);
    memcpy(&raw.temperature, record + 28, 2);
    raw.has_temperature = record[7];
    for (size_t k = 0; k < n_given; k++) {
        float value;
        memcpy(&value, record + RECORD + 4 * k, 4);
        count(fos_hub_give_application(hub, k, value));
        if (k == 0)
            count(fos_hub_give(hub, FOS_QUANTITY_SUPPLY_V, value));
    }
    count(fos_hub_set_motion(hub, motion));
    count(fos_hub_update(hub, &raw, &place.output));
    digest(&crc_of_outputs, &place.output, sizeof place.output);
    if (clock_us != 0)
        count(fos_hub_clock(hub, clock_us));
    if (count(fos_telemetry_sample(hub, frame, sizeof frame, &used)))
        digest(&crc_of_telemetry, frame, used);
}

static int untouched(const void *start, size_t length)
{
    const uint8_t *bytes = start;
    while (length-- > 0)
        if (*bytes++ != 0x5a)
            return 0;
    return 1;
}

int main(int argc, char **argv)
{
    FILE *of_image = argc == 3 ? fopen(argv[1], "rb") : NULL, *log = argc == 3 ? fopen(argv[2], "rb") : NULL;
    uint8_t header[HEADER];
    if (of_image == NULL || log == NULL || fread(header, 1, HEADER, log) != HEADER) {
        printf("usage: old_program IMAGE LOG\n");
        return 2;
    }
    size_t length = fread(image, 1, sizeof image, of_image), n_given = header[6], used = 0;
    fos_scales scales;
    memset(&scales, 0, sizeof scales);
    memcpy(&scales.accel_mps2, header + 8, 4);
    memcpy(&scales.gyro_rads, header + 12, 4);
    memcpy(&scales.temperature_k, header + 16, 4);
    memcpy(&scales.temperature_zero_c, header + 20, 4);
    memcpy(&scales.period_s, header + 24, 8);
    scales.values = header[7];
    memset(&memory, 0x5a, sizeof memory);
    memset(&place, 0x5a, sizeof place);
    fos_hub *hub;
    if (!count(fos_hub_init(&memory.hub, sizeof memory.hub, &scales, &hub)) || !count(fos_hub_load(hub, image, length)))
        return 1;
    if (count(fos_telemetry_start(hub, image, length, frame, sizeof frame, &used)))
        digest(&crc_of_telemetry, frame, used);
    unsigned long samples = 0;
    while (fread(record, 1, RECORD + 4 * n_given, log) == RECORD + 4 * n_given) {
        step(hub, n_given);
        samples++;
    }
    float rate_hz = 0.0f;
    count(fos_hub_rate_hz(hub, &rate_hz));
    printf("samples %lu, outputs %08lx, telemetry %08lx, rate %.6f Hz, drift", samples, (unsigned long)crc_of_outputs,
           (unsigned long)crc_of_telemetry, (double)rate_hz);
    for (size_t axis = 0; axis < FOS_AXES; axis++) {
        uint8_t drift = 0;
        count(fos_hub_drift(hub, axis, &drift));
        printf(" %u", drift);
    }
    count(fos_hub_restart_watch(hub));
    count(fos_hub_load(hub, image, length - 1));
    printf("\n");
    for (int status = 0; status <= FOS_STATUS_OTHER_QUANTITY; status++)
        printf("%s: %lu\n", fos_status_text(status), statuses[status]);
    for (unsigned bit = 1; bit <= FOS_VALIDITY_NOT_MODELLED; bit *= 2)
        printf("%s\n", fos_validity_text((uint16_t)bit));
    printf("hub %lu bytes, aligned to %lu\n", (unsigned long)fos_hub_size(), (unsigned long)fos_hub_align());
    if (!untouched(memory.guard, sizeof memory.guard) || !untouched(place.guard, sizeof place.guard)) {
        printf("memory behind a hub or an output was touched\n");
        return 1;
    }
    return fos_api_version() >= 1 && fos_version() != NULL ? 0 : 1;
}
