/* check_streams: every function of the streams with arguments that it must refuse, and with stamps that it must survive. */
#include "check.h"

enum { MS = 1000000 };

static const fos_stream_periods PERIODS = {5 * MS, 10 * MS, 1000 * MS};

static fos_streams *made(void)
{
    fos_streams *streams = NULL;
    uint8_t *memory = before_guard(fos_streams_size());
    memset(memory, 0xa5, fos_streams_size());
    EXPECT(fos_streams_init(memory, fos_streams_size(), &PERIODS, &streams) == FOS_STATUS_OK);
    EXPECT((uint8_t *)streams == memory);
    return streams;
}

static void drop_streams(fos_streams *streams) { drop((uint8_t *)streams, fos_streams_size()); }

static void expect_none(void *memory, size_t size, const fos_stream_periods *periods, fos_status status)
{
    fos_streams *streams = (fos_streams *)(void *)&expected;
    EXPECT(fos_streams_init(memory, size, periods, &streams) == status && streams == NULL);
}

static void init_refuses(void)
{
    static uint64_t memory[FOS_STREAMS_BYTES / 8 + 1];
    uint8_t *bytes = (uint8_t *)memory;
    void *out[2] = {NULL, NULL};
    EXPECT(fos_streams_size() > 0 && fos_streams_size() <= FOS_STREAMS_BYTES);
    EXPECT(fos_streams_align() > 0 && fos_streams_align() <= FOS_STREAMS_ALIGN && FOS_STREAMS_BYTES % FOS_STREAMS_ALIGN == 0);
    EXPECT(fos_streams_init(memory, sizeof memory, &PERIODS, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_streams_init(memory, sizeof memory, &PERIODS, (fos_streams **)(void *)((uint8_t *)out + 1)) ==
           FOS_STATUS_MISALIGNED);
    EXPECT(out[0] == NULL && out[1] == NULL);
    expect_none(NULL, sizeof memory, &PERIODS, FOS_STATUS_NULL);
    expect_none(memory, sizeof memory, NULL, FOS_STATUS_NULL);
    expect_none(memory, SIZE_MAX, &PERIODS, FOS_STATUS_ARGUMENT);
    for (size_t size = 0; size < fos_streams_size(); size++)
        expect_none(memory, size, &PERIODS, FOS_STATUS_NO_ROOM);
    for (size_t off = 1; off < fos_streams_align(); off++)
        expect_none(bytes + off, sizeof memory - off, &PERIODS, FOS_STATUS_MISALIGNED);
    uint64_t spare[5] = {0};
    expect_none(memory, sizeof memory, (const fos_stream_periods *)(const void *)((uint8_t *)spare + 1),
                FOS_STATUS_MISALIGNED);
    const fos_stream_periods wrong[] = {
        {0, 1, 1}, {1, 0, 1}, {UINT64_C(1) << 63, 1, 1}, {1, UINT64_MAX, 1}, {1, 1, UINT64_MAX},
    };
    fos_streams *streams = made();
    for (int n = 0; n < 5; n++) {
        expect_none(memory, sizeof memory, &wrong[n], FOS_STATUS_ARGUMENT);
        EXPECT(fos_streams_set_periods(streams, &wrong[n]) == FOS_STATUS_ARGUMENT);
    }
    const fos_stream_periods extreme[] = {{1, 1, 0}, {INT64_MAX, INT64_MAX, INT64_MAX}};
    for (int n = 0; n < 2; n++)
        EXPECT(fos_streams_set_periods(streams, &extreme[n]) == FOS_STATUS_OK);
    EXPECT(fos_streams_set_periods(NULL, &PERIODS) == FOS_STATUS_NULL);
    EXPECT(fos_streams_set_periods(streams, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_streams_set_periods((fos_streams *)((uint8_t *)streams + 1), &PERIODS) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_set_periods(streams, (fos_stream_periods *)(void *)((uint8_t *)spare + 1)) == FOS_STATUS_MISALIGNED);
    drop_streams(streams);
}

static void calls_refuse(void)
{
    fos_streams *streams = made(), *odd = (fos_streams *)((uint8_t *)streams + 1);
    uint64_t spare[10] = {0};
    uint8_t *beside = (uint8_t *)spare + 1;
    const float value[3] = {0.1f, 0.2f, 9.8f};
    fos_si_sample sample = {.skipped = 77};
    int64_t stamp_ns = 7;
    fos_stream_counts counts;
    EXPECT(fos_streams_gyro(NULL, 0, value) == FOS_STATUS_NULL && fos_streams_gyro(streams, 0, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_streams_gyro(odd, 0, value) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_gyro(streams, 0, (const float *)(void *)beside) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_accel(NULL, 0, value) == FOS_STATUS_NULL && fos_streams_accel(streams, 0, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_streams_accel(odd, 0, value) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_accel(streams, 0, (const float *)(void *)beside) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_temperature(NULL, 0, 25.0f) == FOS_STATUS_NULL);
    EXPECT(fos_streams_temperature(odd, 0, 25.0f) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_counts(NULL, &counts) == FOS_STATUS_NULL && fos_streams_counts(streams, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_streams_counts(odd, &counts) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_streams_counts(streams, (fos_stream_counts *)(void *)beside) == FOS_STATUS_MISALIGNED);

    /* nothing of that counted, and a call that is refused takes nothing out */
    EXPECT(fos_streams_counts(streams, &counts) == FOS_STATUS_OK);
    EXPECT(counts.gyro.refused == 0 && counts.accel.refused == 0 && counts.temperature.refused == 0);
    EXPECT(fos_streams_gyro(streams, 5 * MS, value) == FOS_STATUS_OK);
    EXPECT(fos_streams_next(streams, &sample, &stamp_ns) == FOS_STATUS_NOT_KNOWN && sample.skipped == 77 && stamp_ns == 7);
    fos_status (*const give[])(fos_streams *, fos_si_sample *, int64_t *) = {fos_streams_next, fos_streams_flush};
    for (int n = 0; n < 2; n++) {
        EXPECT(give[n](NULL, &sample, &stamp_ns) == FOS_STATUS_NULL && give[n](streams, NULL, &stamp_ns) == FOS_STATUS_NULL);
        EXPECT(give[n](streams, &sample, NULL) == FOS_STATUS_NULL);
        EXPECT(give[n](odd, &sample, &stamp_ns) == FOS_STATUS_MISALIGNED);
        EXPECT(give[n](streams, (fos_si_sample *)(void *)beside, &stamp_ns) == FOS_STATUS_MISALIGNED);
        EXPECT(give[n](streams, &sample, (int64_t *)(void *)beside) == FOS_STATUS_MISALIGNED);
    }
    EXPECT(fos_streams_accel(streams, 5 * MS, value) == FOS_STATUS_OK);
    EXPECT(fos_streams_next(streams, &sample, &stamp_ns) == FOS_STATUS_OK && stamp_ns == 5 * MS && sample.skipped == 0);
    EXPECT(sample.accel[2] == 9.8f && sample.gyro[1] == 0.2f && isnan(sample.temperature_c) && sample.faults == 0);
    EXPECT(fos_streams_flush(streams, &sample, &stamp_ns) == FOS_STATUS_NOT_KNOWN);

    const float not_finite[3] = {0.0f, NAN, 0.0f};
    EXPECT(fos_streams_gyro(streams, 5 * MS, value) == FOS_STATUS_NOT_TAKEN);
    EXPECT(fos_streams_accel(streams, 0, value) == FOS_STATUS_NOT_TAKEN);
    EXPECT(fos_streams_accel(streams, 15 * MS, not_finite) == FOS_STATUS_NOT_TAKEN);
    EXPECT(fos_streams_temperature(streams, 0, INFINITY) == FOS_STATUS_NOT_TAKEN);
    EXPECT(fos_streams_gyro(streams, 10 * MS, not_finite) == FOS_STATUS_NOT_TAKEN);
    EXPECT(fos_streams_flush(streams, &sample, &stamp_ns) == FOS_STATUS_OK && stamp_ns == 10 * MS);
    EXPECT(isnan(sample.gyro[0]) && isnan(sample.accel[0]));
    EXPECT(fos_streams_counts(streams, &counts) == FOS_STATUS_OK);
    EXPECT(counts.gyro.refused == 1 && counts.gyro.not_finite == 1 && counts.accel.refused == 1);
    EXPECT(counts.accel.not_finite == 1 && counts.temperature.not_finite == 1 && counts.passed_over == 0);
    drop_streams(streams);
}

/* Every n-th sample of a gyro that is n times as fast, and samples whose places end at a page that must not be touched. */
static void runs(void)
{
    fos_streams *streams = made();
    fos_si_sample *sample = (fos_si_sample *)(void *)before_guard(sizeof *sample);
    int64_t *stamp_ns = (int64_t *)(void *)before_guard(sizeof *stamp_ns);
    float *value = (float *)(void *)before_guard(3 * sizeof *value);
    value[0] = value[1] = value[2] = 1.0f;
    unsigned given = 0;
    EXPECT(fos_streams_temperature(streams, 0, 30.0f) == FOS_STATUS_OK);
    for (int64_t n = 0; n <= 1000; n++) {
        EXPECT(fos_streams_gyro(streams, n * 5 * MS / 2, value) == FOS_STATUS_OK);
        if (n % 4 == 0)
            EXPECT(fos_streams_accel(streams, n * 5 * MS / 2, value) == FOS_STATUS_OK);
        while (fos_streams_next(streams, sample, stamp_ns) == FOS_STATUS_OK) {
            EXPECT(*stamp_ns == (int64_t)given * 5 * MS && sample->skipped == 0 && sample->accel[0] == 1.0f);
            EXPECT(sample->temperature_c == 30.0f);
            given++;
        }
    }
    fos_stream_counts counts;
    EXPECT(fos_streams_counts(streams, &counts) == FOS_STATUS_OK && given == 501 && counts.passed_over == 500);

    for (uint32_t n = 0; n < 300000; n++) {
        int64_t stamp = (int64_t)((uint64_t)random_bits() << 32 | random_bits());
        if (random_bits() % 4 != 0)
            stamp = (int64_t)n * MS;
        value[random_bits() % 3] = random_bits() % 8 == 0 ? ODD[random_bits() % N_ODD] : 1.0f;
        fos_status status = random_bits() % 3 == 0   ? fos_streams_gyro(streams, stamp, value)
                            : random_bits() % 2 == 0 ? fos_streams_accel(streams, stamp, value)
                                                     : fos_streams_temperature(streams, stamp, value[0]);
        EXPECT(status == FOS_STATUS_OK || status == FOS_STATUS_NOT_TAKEN);
        while ((random_bits() % 64 ? fos_streams_next : fos_streams_flush)(streams, sample, stamp_ns) == FOS_STATUS_OK) {
            EXPECT(sample->faults == 0 || sample->faults == FOS_FAULT_RESET);
            given++;
        }
    }
    printf("streams: %u samples given, %lu bytes\n", given, (unsigned long)fos_streams_size());
    drop((uint8_t *)sample, sizeof *sample);
    drop((uint8_t *)stamp_ns, sizeof *stamp_ns);
    drop((uint8_t *)value, 3 * sizeof *value);
    drop_streams(streams);
}

int main(void)
{
    init_refuses();
    calls_refuse();
    runs();
    printf("streams: %lu checks hold\n", expected);
    return 0;
}
