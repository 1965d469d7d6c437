/*
 * replay IMAGE LOG: runs a log of raw codes through a stored model, on the host and on the emulated board.
 *
 * Prints how many samples there were, and a digest (CRC-64/XZ) of everything that came out. The same samples go through
 * a second hub as values in SI units, and must come to the same. The log is described in
 * fos-embedded/src/test_log/hub_log.rs.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fos.h"

enum { HEADER = 32, RECORD = 32, MAX_IMAGE = 32768 };

enum { OF_CODES, OF_VALUES };

static uint64_t memory[2][FOS_HUB_BYTES / 8];
static fos_hub *hubs[2];
static fos_scales scales;
static uint8_t image[MAX_IMAGE];

static void fail(const char *what, const char *why)
{
    printf("%s: %s\n", what, why);
    exit(1);
}

static void check(const char *what, fos_status status)
{
    if (status != FOS_STATUS_OK)
        fail(what, fos_status_text(status));
}

static uint64_t little_endian(const uint8_t *bytes, int n)
{
    uint64_t value = 0;
    while (n-- > 0)
        value = value << 8 | bytes[n];
    return value;
}

static uint16_t u16_at(const uint8_t *bytes) { return (uint16_t)little_endian(bytes, 2); }

static int16_t i16_at(const uint8_t *bytes)
{
    uint16_t bits = u16_at(bytes);
    int16_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static float f32_at(const uint8_t *bytes)
{
    uint32_t bits = (uint32_t)little_endian(bytes, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double f64_at(const uint8_t *bytes)
{
    uint64_t bits = little_endian(bytes, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* CRC-64/XZ, bit by bit: the polynomial of ECMA-182 reflected, starting at and finished with all ones. */
static uint64_t crcs[2] = {UINT64_MAX, UINT64_MAX};

static void digest(uint64_t *crc, uint64_t value, int n_bytes)
{
    for (int n = 0; n < n_bytes; n++) {
        *crc ^= value >> (8 * n) & 0xff;
        for (int bit = 0; bit < 8; bit++)
            *crc = *crc >> 1 ^ (*crc & 1 ? UINT64_C(0xc96c5795d7870f42) : 0);
    }
}

static void digest_float(uint64_t *crc, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    digest(crc, value == value ? bits : UINT32_C(0x7fc00000), 4); /* there are many NaN; one stands for all */
}

static void digest_output(uint64_t *crc, const fos_output *output)
{
    for (int axis = 0; axis < FOS_AXES; axis++) {
        digest_float(crc, output->corrected[axis]);
        digest_float(crc, output->innovation[axis]);
        digest(crc, output->validity[axis], 2);
    }
    digest(crc, output->still, 1);
    digest(crc, output->faults, 2);
    digest(crc, output->drift, 1);
}

static FILE *open(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        fail(path, "cannot be opened");
    return file;
}

static void start(const uint8_t *header, size_t image_length)
{
    scales = (fos_scales){
        .accel_mps2 = f32_at(header + 8),
        .gyro_rads = f32_at(header + 12),
        .temperature_k = f32_at(header + 16),
        .temperature_zero_c = f32_at(header + 20),
        .period_s = f64_at(header + 24),
        .values = header[7],
    };
    for (int of = OF_CODES; of <= OF_VALUES; of++) {
        check("scales", fos_hub_init(memory[of], sizeof memory[of], &scales, &hubs[of]));
        check("image", fos_hub_load(hubs[of], image, image_length));
    }
}

/* What the hub makes of codes, in the same arithmetic. */
static fos_si_sample values_of(const fos_raw_sample *raw)
{
    fos_si_sample sample = {.skipped = raw->skipped, .faults = raw->faults};
    for (int axis = 0; axis < 3; axis++) {
        sample.accel[axis] = (float)raw->accel[axis] * scales.accel_mps2;
        sample.gyro[axis] = (float)raw->gyro[axis] * scales.gyro_rads;
    }
    float above_zero = (float)raw->temperature * scales.temperature_k;
    sample.temperature_c = raw->has_temperature ? above_zero + scales.temperature_zero_c : NAN;
    return sample;
}

static void step(const uint8_t *record, size_t n_given)
{
    fos_raw_sample raw = {
        .skipped = (uint32_t)little_endian(record, 4),
        .accel = {i16_at(record + 16), i16_at(record + 18), i16_at(record + 20)},
        .gyro = {i16_at(record + 22), i16_at(record + 24), i16_at(record + 26)},
        .temperature = i16_at(record + 28),
        .faults = u16_at(record + 4),
        .has_temperature = record[7],
    };
    fos_si_sample values = values_of(&raw);
    uint64_t clock_us = little_endian(record + 8, 8);
    for (int of = OF_CODES; of <= OF_VALUES; of++) {
        fos_hub *hub = hubs[of];
        for (size_t k = 0; k < n_given; k++)
            check("quantity", fos_hub_give_application(hub, k, f32_at(record + RECORD + 4 * k)));
        check("motion", fos_hub_set_motion(hub, record[6]));
        fos_si_output si;
        if (of == OF_CODES)
            check("sample", fos_hub_update(hub, &raw, &si.output));
        else
            check("values", fos_hub_update_si(hub, &values, &si));
        digest_output(&crcs[of], &si.output);
        if (clock_us != 0)
            check("clock", fos_hub_clock(hub, clock_us));
    }
}

int main(int argc, char **argv)
{
    if (argc != 3)
        fail("usage", "replay IMAGE LOG");
    FILE *file = open(argv[1]);
    size_t image_length = fread(image, 1, sizeof image, file);
    fclose(file);

    file = open(argv[2]);
    uint8_t header[HEADER];
    if (fread(header, 1, HEADER, file) != HEADER || memcmp(header, "FOSH", 4) != 0)
        fail(argv[2], "not a log of raw codes");
    if (u16_at(header + 4) != 1)
        fail(argv[2], "a log of raw codes of another version; this program reads version 1");
    size_t n_given = header[6];
    start(header, image_length);
    /* the model takes as many quantities as the log gives, and no more */
    if (fos_hub_give_application(hubs[OF_CODES], n_given, 0.0f) == FOS_STATUS_OK)
        fail(argv[2], "the model needs more quantities than the log gives");

    static uint8_t record[RECORD + 4 * UINT8_MAX];
    size_t length = RECORD + 4 * n_given, got;
    unsigned long samples = 0;
    while ((got = fread(record, 1, length, file)) == length) {
        step(record, n_given);
        samples++;
    }
    if (got != 0 || ferror(file))
        fail(argv[2], "ends within a record");
    fclose(file);
    if (crcs[OF_VALUES] != crcs[OF_CODES])
        fail(argv[2], "as values in SI units it comes to something else");
    uint64_t crc = ~crcs[OF_CODES];
    printf("samples %lu\noutputs %08lx%08lx\n", samples, (unsigned long)(crc >> 32),
           (unsigned long)(crc & UINT32_MAX));
    return 0;
}
