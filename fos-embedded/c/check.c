/*
 * check IMAGE: every function with arguments that it must refuse, and with images and samples that it must survive.
 */
#include "check.h"

static const fos_scales SCALES = {
    .accel_mps2 = 0.001197f,
    .gyro_rads = 0.000305f,
    .temperature_k = 1.0f / 256.0f,
    .temperature_zero_c = 25.0f,
    .period_s = 0.005,
    .values = FOS_VALUES_RAW,
};

static uint8_t image[32768];
static size_t image_length;

static fos_hub *hub_with(const fos_scales *scales)
{
    fos_hub *hub = NULL;
    uint8_t *memory = before_guard(fos_hub_size());
    memset(memory, 0xa5, fos_hub_size());
    EXPECT(fos_hub_init(memory, fos_hub_size(), scales, &hub) == FOS_STATUS_OK);
    EXPECT((uint8_t *)hub == memory);
    return hub;
}

static void drop_hub(fos_hub *hub) { drop((uint8_t *)hub, fos_hub_size()); }

static fos_hub *loaded(void)
{
    fos_hub *hub = hub_with(&SCALES);
    EXPECT(fos_hub_load(hub, image, image_length) == FOS_STATUS_OK);
    return hub;
}

static fos_raw_sample lying_still(void)
{
    fos_raw_sample raw = {.accel = {0, 0, 8192}, .temperature = 256, .has_temperature = 1};
    for (int axis = 0; axis < 3; axis++) {
        raw.accel[axis] = (int16_t)(raw.accel[axis] + (int16_t)(random_bits() % 16));
        raw.gyro[axis] = (int16_t)(random_bits() % 8);
    }
    return raw;
}

/* Everything that is never NaN is finite, and there is no bit that has no name. */
static void expect_sound(const fos_output *output)
{
    for (int axis = 0; axis < FOS_AXES; axis++) {
        EXPECT(isfinite(output->measured[axis]) && isfinite(output->corrected[axis]));
        EXPECT(!isinf(output->innovation[axis]));
        EXPECT(output->validity[axis] < 2 * FOS_VALIDITY_AWAY_FROM_GRAVITY);
    }
    EXPECT(!isinf(output->temperature_c));
    EXPECT(output->faults < 2 * FOS_FAULT_RATE && output->still <= 1 && output->drift <= 1);
}

static void has_no_model(fos_hub *hub)
{
    fos_raw_sample raw = lying_still();
    fos_output output;
    uint8_t drift = 9;
    EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK);
    for (int axis = 0; axis < FOS_AXES; axis++) {
        EXPECT(output.validity[axis] & FOS_VALIDITY_NOT_MODELLED);
        EXPECT(output.corrected[axis] == output.measured[axis]);
    }
    EXPECT(fos_hub_drift(hub, FOS_GZ, &drift) == FOS_STATUS_NOT_IN_MODEL && drift == 0);
    EXPECT(fos_hub_give_application(hub, 0, 1.0f) == FOS_STATUS_NOT_IN_MODEL);
}

static void sizes_and_texts(void)
{
    EXPECT(fos_api_version() == FOS_API_VERSION);
    EXPECT(strlen(fos_version()) >= 5);
    EXPECT(fos_hub_size() > 0 && fos_hub_size() <= FOS_HUB_BYTES);
    EXPECT(fos_hub_align() > 0 && fos_hub_align() <= FOS_HUB_ALIGN && FOS_HUB_BYTES % FOS_HUB_ALIGN == 0);
    for (int32_t status = -3; status < 100; status++) {
        int known = status >= FOS_STATUS_OK && status <= FOS_STATUS_OTHER_PART;
        EXPECT((strcmp(fos_status_text(status), "unknown status") != 0) == known);
    }
    EXPECT(strcmp(fos_status_text(INT32_MIN), "unknown status") == 0);
    for (unsigned bits = 0; bits <= UINT16_MAX; bits++) {
        int known = (bits & (bits - 1)) == 0 && bits <= FOS_VALIDITY_AWAY_FROM_GRAVITY;
        EXPECT((strcmp(fos_validity_text((uint16_t)bits), "unknown validity") != 0) == known);
    }
}

static void expect_no_hub(void *memory, size_t size, const fos_scales *scales, fos_status status)
{
    fos_hub *hub = (fos_hub *)&expected;
    EXPECT(fos_hub_init(memory, size, scales, &hub) == status && hub == NULL);
}

static void init_refuses(void)
{
    static uint64_t memory[FOS_HUB_BYTES / 8 + 1];
    uint8_t *bytes = (uint8_t *)memory;
    fos_hub *hub = NULL;
    void *out[2] = {NULL, NULL};
    EXPECT(fos_hub_init(memory, sizeof memory, &SCALES, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_init(memory, sizeof memory, &SCALES, (fos_hub **)(void *)((uint8_t *)out + 1)) == FOS_STATUS_MISALIGNED);
    EXPECT(out[0] == NULL && out[1] == NULL);
    expect_no_hub(NULL, sizeof memory, &SCALES, FOS_STATUS_NULL);
    expect_no_hub(memory, sizeof memory, NULL, FOS_STATUS_NULL);
    expect_no_hub(memory, SIZE_MAX, &SCALES, FOS_STATUS_ARGUMENT);
    expect_no_hub(memory, (size_t)1 << (8 * sizeof(size_t) - 1), &SCALES, FOS_STATUS_ARGUMENT);
    for (size_t size = 0; size < fos_hub_size(); size++) {
        expect_no_hub(memory, size, &SCALES, FOS_STATUS_NO_ROOM);
    }
    for (size_t off = 1; off < fos_hub_align(); off++) {
        expect_no_hub(bytes + off, sizeof memory - off, &SCALES, FOS_STATUS_MISALIGNED);
    }
    uint8_t moved[sizeof SCALES + 8];
    memcpy(moved + 4 - (uintptr_t)moved % 4 + 1, &SCALES, sizeof SCALES - 1);
    expect_no_hub(memory, sizeof memory, (const fos_scales *)(const void *)(moved + 4 - (uintptr_t)moved % 4 + 1),
                  FOS_STATUS_MISALIGNED);

    const double wrong[] = {0.0, -1.0, NAN, INFINITY, -INFINITY};
    for (size_t n = 0; n < sizeof wrong / sizeof *wrong; n++) {
        fos_scales scales = SCALES;
        scales.accel_mps2 = (float)wrong[n];
        expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
        scales = SCALES;
        scales.gyro_rads = (float)wrong[n];
        expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
        scales = SCALES;
        scales.period_s = wrong[n];
        expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
        if (!isfinite(wrong[n])) {
            scales = SCALES;
            scales.temperature_k = (float)wrong[n];
            expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
            scales = SCALES;
            scales.temperature_zero_c = (float)wrong[n];
            expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
        }
    }
    fos_scales scales = SCALES;
    scales.accel_mps2 = 1e35f; /* its largest code is no float */
    expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
    for (unsigned values = 2; values <= UINT8_MAX; values++) {
        scales = SCALES;
        scales.values = (uint8_t)values;
        expect_no_hub(memory, sizeof memory, &scales, FOS_STATUS_ARGUMENT);
    }
    EXPECT(fos_hub_init(memory, sizeof memory, &SCALES, &hub) == FOS_STATUS_OK && hub == (void *)memory);
    has_no_model(hub);
}

static void run_random(fos_hub *hub, int samples)
{
    fos_raw_sample raw;
    fos_output output;
    while (samples-- > 0) {
        uint32_t *words = (uint32_t *)(void *)&raw;
        for (size_t n = 0; n < sizeof raw / 4; n++)
            words[n] = random_bits();
        if (samples % 8 != 0)
            raw.skipped = 0;
        if (samples % 3 != 0)
            raw = lying_still();
        (void)fos_hub_set_motion(hub, (fos_motion)(random_bits() % 3));
        EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK);
        expect_sound(&output);
    }
}

static void load_refuses(void)
{
    fos_hub *hub = loaded();
    fos_raw_sample raw = lying_still();
    fos_output output;
    EXPECT(fos_hub_load(NULL, image, image_length) == FOS_STATUS_NULL);
    EXPECT(fos_hub_load((fos_hub *)((uint8_t *)hub + 1), image, image_length) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_load(hub, NULL, image_length) == FOS_STATUS_NULL);
    EXPECT(fos_hub_load(hub, image, SIZE_MAX) == FOS_STATUS_ARGUMENT);
    EXPECT(fos_hub_load(hub, image, SIZE_MAX / 2 + 1) == FOS_STATUS_ARGUMENT);
    EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK);
    EXPECT(!(output.validity[FOS_GZ] & FOS_VALIDITY_NOT_MODELLED)); /* it still has its model */

    for (size_t length = 0; length < image_length; length++) {
        uint8_t *shorter = before_guard(length);
        memcpy(shorter, image, length);
        EXPECT(fos_hub_load(hub, shorter, length) == FOS_STATUS_TRUNCATED);
        drop(shorter, length);
    }
    has_no_model(hub);
    EXPECT(fos_hub_load(hub, image, image_length + 1) == FOS_STATUS_TRAILING_BYTES);

    /* every bit of it */
    uint8_t *copy = before_guard(image_length);
    unsigned seen = 0;
    for (size_t bit = 0; bit < 8 * image_length; bit++) {
        memcpy(copy, image, image_length);
        copy[bit / 8] ^= (uint8_t)(1u << bit % 8);
        fos_status status = fos_hub_load(hub, copy, image_length);
        fos_status expected_status = bit < 32 ? FOS_STATUS_NOT_AN_IMAGE : bit < 64 ? FOS_STATUS_OTHER_VERSION : FOS_STATUS_DAMAGED;
        if (bit == 48) /* the flag of a calibration, which is not there */
            expected_status = FOS_STATUS_DAMAGED;
        if (bit >= 64 && bit < 128) { /* a length */
            EXPECT(status == FOS_STATUS_TRUNCATED || status == FOS_STATUS_TRAILING_BYTES);
        } else {
            EXPECT(status == expected_status);
        }
        seen |= 1u << status;
    }
    has_no_model(hub);

    /* the same with a right checksum: what loads is run */
    unsigned ran = 0;
    for (size_t bit = 160; bit < 8 * image_length; bit++) {
        memcpy(copy, image, image_length);
        copy[bit / 8] ^= (uint8_t)(1u << bit % 8);
        seal(copy, image_length);
        fos_status status = fos_hub_load(hub, copy, image_length);
        seen |= 1u << status;
        EXPECT(status == FOS_STATUS_OK || status >= FOS_STATUS_TRUNCATED);
        if (status == FOS_STATUS_OK) {
            run_random(hub, 40);
            ran++;
        }
    }
    for (int n = 0; n < 20000; n++) {
        memcpy(copy, image, image_length);
        for (uint32_t left = random_bits() % 8 + 1; left > 0; left--)
            copy[20 + random_bits() % (image_length - 20)] = (uint8_t)random_bits();
        seal(copy, image_length);
        fos_status status = fos_hub_load(hub, copy, image_length);
        seen |= 1u << status;
        if (status == FOS_STATUS_OK) {
            run_random(hub, 10);
            ran++;
        }
    }
    printf("damaged images with a right checksum: %u loaded and ran\n", ran);
    EXPECT(ran > 1000);
    EXPECT(seen & 1u << FOS_STATUS_UNUSABLE && seen & 1u << FOS_STATUS_OTHER_PERIOD && seen & 1u << FOS_STATUS_OTHER_VALUES);
    EXPECT(fos_hub_load(hub, image, image_length) == FOS_STATUS_OK); /* after all that */
    drop(copy, image_length);
    drop_hub(hub);

    fos_scales scales = SCALES;
    scales.values = FOS_VALUES_FACTORY_CORRECTED;
    hub = hub_with(&scales);
    EXPECT(fos_hub_load(hub, image, image_length) == FOS_STATUS_OTHER_VALUES);
    drop_hub(hub);
    scales = SCALES;
    scales.period_s *= 1.12;
    hub = hub_with(&scales);
    EXPECT(fos_hub_load(hub, image, image_length) == FOS_STATUS_OTHER_PERIOD);
    has_no_model(hub);
    drop_hub(hub);
}

static void update_refuses(void)
{
    fos_hub *hub = loaded();
    fos_raw_sample raw = lying_still();
    fos_output output, before;
    EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK && output.tick == 0);
    before = output;
    uint64_t spare[16] = {0};
    uint8_t *odd = (uint8_t *)spare + 1;
    EXPECT(fos_hub_update(NULL, &raw, &output) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update(hub, NULL, &output) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update(hub, &raw, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update((fos_hub *)odd, &raw, &output) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_update(hub, (fos_raw_sample *)(void *)odd, &output) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_update(hub, &raw, (fos_output *)(void *)odd) == FOS_STATUS_MISALIGNED);
    EXPECT(memcmp(&before, &output, sizeof output) == 0);
    EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK && output.tick == 1); /* they counted for nothing */

    fos_raw_sample *last_raw = (fos_raw_sample *)(void *)before_guard(sizeof raw);
    fos_output *last_output = (fos_output *)(void *)before_guard(sizeof output);
    *last_raw = raw;
    EXPECT(fos_hub_update(hub, last_raw, last_output) == FOS_STATUS_OK && last_output->tick == 2);
    run_random(hub, 200000);
    drop((uint8_t *)last_raw, sizeof raw);
    drop((uint8_t *)last_output, sizeof output);
    drop_hub(hub);
}

static void scales_of_full_scale_refuses(void)
{
    fos_scales scales = SCALES, before;
    memcpy(&before, &scales, sizeof before); /* with what lies between the fields */
    uint64_t spare[8] = {0};
    fos_scales *odd = (fos_scales *)(void *)((uint8_t *)spare + 1);
    EXPECT(fos_scales_of_full_scale(78.4f, 34.9f, 0.005, FOS_VALUES_RAW, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_scales_of_full_scale(78.4f, 34.9f, 0.005, FOS_VALUES_RAW, odd) == FOS_STATUS_MISALIGNED);
    for (int n = 0; n < N_ODD; n++) {
        if (ODD[n] == FLT_MAX)
            continue;
        EXPECT(fos_scales_of_full_scale(ODD[n], 34.9f, 0.005, FOS_VALUES_RAW, &scales) == FOS_STATUS_ARGUMENT);
        EXPECT(fos_scales_of_full_scale(78.4f, ODD[n], 0.005, FOS_VALUES_RAW, &scales) == FOS_STATUS_ARGUMENT);
    }
    const double wrong[] = {0.0, -0.005, NAN, INFINITY, -INFINITY};
    for (size_t n = 0; n < sizeof wrong / sizeof *wrong; n++)
        EXPECT(fos_scales_of_full_scale(78.4f, 34.9f, wrong[n], FOS_VALUES_RAW, &scales) == FOS_STATUS_ARGUMENT);
    for (unsigned values = 2; values <= UINT8_MAX; values++)
        EXPECT(fos_scales_of_full_scale(78.4f, 34.9f, 0.005, (uint8_t)values, &scales) == FOS_STATUS_ARGUMENT);
    EXPECT(memcmp(&scales, &before, sizeof scales) == 0); /* nothing was written */

    const float full_scales[] = {78.4532f, 1e-30f, 3.4027e38f, FLT_MAX};
    for (int n = 0; n < 4; n++) {
        EXPECT(fos_scales_of_full_scale(full_scales[n], full_scales[n], 0.005, n & 1, &scales) == FOS_STATUS_OK);
        EXPECT(scales.temperature_k == 0.0f && scales.period_s == 0.005 && scales.values == (n & 1));
        fos_hub *hub = hub_with(&scales); /* what is accepted here is accepted there */
        fos_si_sample sample = {.accel = {full_scales[n]}, .temperature_c = NAN};
        fos_si_output si;
        EXPECT(fos_hub_update_si(hub, &sample, &si) == FOS_STATUS_OK);
        EXPECT(si.output.validity[FOS_AX] & FOS_VALIDITY_SATURATED && !(si.output.validity[FOS_AY] & FOS_VALIDITY_SATURATED));
        drop_hub(hub);
    }
}

static void update_si_refuses(void)
{
    fos_hub *hub = loaded();
    fos_si_sample sample = {.accel = {0.01f, -0.02f, 9.8f}, .gyro = {0.001f, 0.002f, -0.003f}, .temperature_c = 26.0f};
    fos_si_output output, before;
    EXPECT(fos_hub_update_si(hub, &sample, &output) == FOS_STATUS_OK && output.output.tick == 0);
    before = output;
    uint64_t spare[20] = {0};
    uint8_t *odd = (uint8_t *)spare + 1;
    EXPECT(fos_hub_update_si(NULL, &sample, &output) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update_si(hub, NULL, &output) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update_si(hub, &sample, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_update_si((fos_hub *)odd, &sample, &output) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_update_si(hub, (fos_si_sample *)(void *)odd, &output) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_update_si(hub, &sample, (fos_si_output *)(void *)odd) == FOS_STATUS_MISALIGNED);
    EXPECT(memcmp(&before, &output, sizeof output) == 0);
    EXPECT(fos_hub_update_si(hub, &sample, &output) == FOS_STATUS_OK && output.output.tick == 1);

    /* the sample may lie where the output goes */
    union {
        fos_si_sample sample;
        fos_si_output output;
    } one;
    one.sample = sample;
    EXPECT(fos_hub_update_si(hub, &one.sample, &one.output) == FOS_STATUS_OK && one.output.output.tick == 2);
    EXPECT(one.output.output.measured[FOS_AZ] == 9.8f);

    fos_si_sample *last_sample = (fos_si_sample *)(void *)before_guard(sizeof sample);
    fos_si_output *last_output = (fos_si_output *)(void *)before_guard(sizeof output);
    for (uint32_t n = 0; n < 200000; n++) {
        *last_sample = sample;
        float *values[] = {last_sample->accel, last_sample->gyro, &last_sample->temperature_c};
        for (int axis = 0; axis < 7; axis++) {
            float *value = &values[axis / 3][axis % 3], bits;
            uint32_t random = random_bits();
            memcpy(&bits, &random, sizeof bits);
            random = random_bits();
            *value = random % 16 == 0 ? ODD[random / 16 % N_ODD] : random % 16 == 1 ? bits : *value + (float)(random % 97) * 1e-5f;
        }
        last_sample->skipped = n % 8 == 0 ? random_bits() : 0;
        last_sample->faults = n % 16 == 0 ? (uint16_t)random_bits() : 0;
        EXPECT(fos_hub_update_si(hub, last_sample, last_output) == FOS_STATUS_OK);
        for (int axis = 0; axis < FOS_AXES; axis++) {
            EXPECT(isfinite(last_output->output.corrected[axis]) && isfinite(last_output->predicted[axis]));
            EXPECT(!isinf(last_output->output.innovation[axis]));
            if (!isfinite(last_output->output.measured[axis]))
                EXPECT(last_output->output.validity[axis] & (FOS_VALIDITY_NOT_FINITE | FOS_VALIDITY_SATURATED));
        }
        EXPECT(!isinf(last_output->output.temperature_c));
    }
    drop((uint8_t *)last_sample, sizeof sample);
    drop((uint8_t *)last_output, sizeof output);
    drop_hub(hub);
}

static void the_rest_refuses(void)
{
    fos_hub *hub = loaded();
    fos_hub *odd = (fos_hub *)((uint8_t *)hub + 1);
    uint64_t spare[2] = {0};
    float *odd_float = (float *)(void *)((uint8_t *)spare + 1), rate_hz = 0.0f;
    uint8_t drift = 9;

    EXPECT(fos_hub_give(NULL, FOS_QUANTITY_SUPPLY_V, 3.3f) == FOS_STATUS_NULL);
    EXPECT(fos_hub_give(odd, FOS_QUANTITY_SUPPLY_V, 3.3f) == FOS_STATUS_MISALIGNED);
    for (unsigned quantity = 0; quantity <= UINT8_MAX; quantity++) {
        int known = quantity <= FOS_QUANTITY_MAGNETIC_Z_UT ||
                    (quantity >= FOS_QUANTITY_REFERENCE && quantity < FOS_QUANTITY_REFERENCE + FOS_AXES);
        fos_status expected_status = quantity == FOS_QUANTITY_SUPPLY_V ? FOS_STATUS_OK
                                     : known                           ? FOS_STATUS_NOT_IN_MODEL
                                                                       : FOS_STATUS_ARGUMENT;
        EXPECT(fos_hub_give(hub, (fos_quantity)quantity, 3.3f) == expected_status);
    }
    EXPECT(fos_hub_give(hub, FOS_QUANTITY_SUPPLY_V, NAN) == FOS_STATUS_OK);
    EXPECT(fos_hub_give(hub, FOS_QUANTITY_SUPPLY_V, -INFINITY) == FOS_STATUS_OK);
    run_random(hub, 100);

    EXPECT(fos_hub_give_application(NULL, 0, 1.0f) == FOS_STATUS_NULL);
    EXPECT(fos_hub_give_application(odd, 0, 1.0f) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_give_application(hub, 1, 1.0f) == FOS_STATUS_OK); /* the model has two such */
    EXPECT(fos_hub_give_application(hub, 2, 1.0f) == FOS_STATUS_NOT_IN_MODEL);
    EXPECT(fos_hub_give_application(hub, SIZE_MAX, 1.0f) == FOS_STATUS_NOT_IN_MODEL);

    EXPECT(fos_hub_set_motion(NULL, FOS_MOTION_STILL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_set_motion(odd, FOS_MOTION_STILL) == FOS_STATUS_MISALIGNED);
    for (unsigned motion = 0; motion <= UINT8_MAX; motion++)
        EXPECT(fos_hub_set_motion(hub, (fos_motion)motion) ==
               (motion <= FOS_MOTION_STILL ? FOS_STATUS_OK : FOS_STATUS_ARGUMENT));

    EXPECT(fos_hub_clock(NULL, 1) == FOS_STATUS_NULL && fos_hub_clock(odd, 1) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_clock(hub, UINT64_MAX) == FOS_STATUS_OK && fos_hub_clock(hub, 0) == FOS_STATUS_OK);
    EXPECT(fos_hub_rate_hz(NULL, &rate_hz) == FOS_STATUS_NULL && fos_hub_rate_hz(hub, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_rate_hz(odd, &rate_hz) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_rate_hz(hub, odd_float) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_rate_hz(hub, &rate_hz) == FOS_STATUS_NOT_KNOWN && isnan(rate_hz));
    EXPECT(fos_hub_load(hub, image, image_length) == FOS_STATUS_OK);
    for (uint64_t n = 0; n < 2400; n++) { /* 12 s at 200 Hz, of a sensor that is 4 % fast */
        fos_raw_sample raw = lying_still();
        fos_output output;
        EXPECT(fos_hub_update(hub, &raw, &output) == FOS_STATUS_OK);
        EXPECT(fos_hub_clock(hub, 1000 + n * 4808) == FOS_STATUS_OK);
    }
    EXPECT(fos_hub_rate_hz(hub, &rate_hz) == FOS_STATUS_OK && rate_hz > 207.0f && rate_hz < 209.0f);

    EXPECT(fos_hub_drift(NULL, FOS_GZ, &drift) == FOS_STATUS_NULL && fos_hub_drift(hub, FOS_GZ, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_hub_drift(odd, FOS_GZ, &drift) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_drift(hub, FOS_AXES, &drift) == FOS_STATUS_ARGUMENT);
    EXPECT(fos_hub_drift(hub, SIZE_MAX, &drift) == FOS_STATUS_ARGUMENT && drift == 9);
    EXPECT(fos_hub_drift(hub, FOS_AY, &drift) == FOS_STATUS_NOT_IN_MODEL && drift == 0);
    EXPECT(fos_hub_drift(hub, FOS_GZ, &drift) == FOS_STATUS_OK && drift <= (FOS_DRIFT_MEAN | FOS_DRIFT_VARIANCE));
    EXPECT(fos_hub_restart_watch(NULL) == FOS_STATUS_NULL && fos_hub_restart_watch(odd) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_hub_restart_watch(hub) == FOS_STATUS_OK);
    EXPECT(fos_hub_drift(hub, FOS_GZ, &drift) == FOS_STATUS_OK && drift == 0);
    drop_hub(hub);
}

/* A frame ends with its only zero. */
static void expect_frame(const uint8_t *frame, size_t used, size_t capacity)
{
    EXPECT(used > 0 && used <= capacity && used <= FOS_TELEMETRY_BYTES);
    EXPECT(memchr(frame, 0, used) == frame + used - 1);
}

static void telemetry_refuses(void)
{
    fos_hub *hub = loaded();
    fos_hub *odd = (fos_hub *)((uint8_t *)hub + 1);
    uint8_t frame[FOS_TELEMETRY_BYTES];
    uint64_t spare[2] = {0};
    size_t *odd_used = (size_t *)(void *)((uint8_t *)spare + 1), used = 9, start = 0, sample = 0;

    EXPECT(fos_telemetry_start(hub, image, image_length, frame, sizeof frame, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_telemetry_start(hub, image, image_length, frame, sizeof frame, odd_used) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_telemetry_start(NULL, image, image_length, frame, sizeof frame, &used) == FOS_STATUS_NULL && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(odd, image, image_length, frame, sizeof frame, &used) == FOS_STATUS_MISALIGNED && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(hub, NULL, image_length, frame, sizeof frame, &used) == FOS_STATUS_NULL && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(hub, image, image_length, NULL, sizeof frame, &used) == FOS_STATUS_NULL && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(hub, image, image_length, frame, SIZE_MAX, &used) == FOS_STATUS_ARGUMENT && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(hub, image, SIZE_MAX, frame, sizeof frame, &used) == FOS_STATUS_ARGUMENT && used == 0);
    used = 9;
    EXPECT(fos_telemetry_start(hub, image, 30, frame, sizeof frame, &used) == FOS_STATUS_TRUNCATED && used == 0);
    EXPECT(fos_telemetry_start(hub, NULL, 0, frame, sizeof frame, &used) == FOS_STATUS_OK && used > 0);

    used = 9;
    EXPECT(fos_telemetry_sample(hub, frame, sizeof frame, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_telemetry_sample(hub, frame, sizeof frame, odd_used) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_telemetry_sample(NULL, frame, sizeof frame, &used) == FOS_STATUS_NULL && used == 0);
    EXPECT(fos_telemetry_sample(odd, frame, sizeof frame, &used) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_telemetry_sample(hub, NULL, sizeof frame, &used) == FOS_STATUS_NULL);
    EXPECT(fos_telemetry_sample(hub, frame, SIZE_MAX, &used) == FOS_STATUS_ARGUMENT);

    run_random(hub, 100);
    EXPECT(fos_telemetry_start(hub, image, image_length, frame, sizeof frame, &start) == FOS_STATUS_OK);
    expect_frame(frame, start, sizeof frame);
    EXPECT(fos_telemetry_sample(hub, frame, sizeof frame, &sample) == FOS_STATUS_OK);
    expect_frame(frame, sample, sizeof frame);
    for (size_t capacity = 0; capacity <= FOS_TELEMETRY_BYTES; capacity++) {
        uint8_t *room = before_guard(capacity);
        fos_status status = fos_telemetry_start(hub, image, image_length, room, capacity, &used);
        EXPECT(status == (capacity >= start ? FOS_STATUS_OK : FOS_STATUS_NO_ROOM));
        EXPECT(used == (status == FOS_STATUS_OK ? start : 0));
        status = fos_telemetry_sample(hub, room, capacity, &used);
        EXPECT(status == (capacity >= sample ? FOS_STATUS_OK : FOS_STATUS_NO_ROOM));
        EXPECT(used == (status == FOS_STATUS_OK ? sample : 0));
        drop(room, capacity);
    }
    printf("telemetry: %lu bytes to start, %lu a sample\n", (unsigned long)start, (unsigned long)sample);
    drop_hub(hub);
}

static void hubs_do_not_know_of_each_other(void)
{
    fos_hub *alone = loaded(), *beside = loaded(), *other = loaded();
    for (int n = 0; n < 1000; n++) {
        fos_raw_sample raw = lying_still(), another = lying_still();
        fos_output a, b, c;
        EXPECT(fos_hub_update(alone, &raw, &a) == FOS_STATUS_OK);
        EXPECT(fos_hub_update(other, &another, &c) == FOS_STATUS_OK);
        EXPECT(fos_hub_update(beside, &raw, &b) == FOS_STATUS_OK);
        EXPECT(memcmp(&a, &b, sizeof a) == 0);
    }
    drop_hub(alone);
    drop_hub(beside);
    drop_hub(other);
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL) {
        printf("usage: check IMAGE\n");
        return 2;
    }
    image_length = fread(image, 1, sizeof image - 1, file);
    fclose(file);
    sizes_and_texts();
    init_refuses();
    load_refuses();
    update_refuses();
    scales_of_full_scale_refuses();
    update_si_refuses();
    the_rest_refuses();
    telemetry_refuses();
    hubs_do_not_know_of_each_other();
    printf("hub: %lu bytes, aligned to %lu\n", (unsigned long)fos_hub_size(), (unsigned long)fos_hub_align());
    printf("%lu checks hold\n", expected);
    return 0;
}
