/* A firmware that is nothing but the hub: with startup.c, cortex-m.ld, the archive and a driver. docs/c.md. */
#include "fos.h"
#include "model.h" /* static const unsigned char model[]: of `xxd -i` or the like, from a model image */

/* The driver's part: waits for the next sample; 0 if there will be no more. */
int read_sensor(fos_raw_sample *raw);
/* The application's part: what it does with a sample, and with what speaks against it. */
void use_sample(const fos_output *output);

static uint64_t memory[FOS_HUB_BYTES / 8];
static fos_scales scales = {
    .accel_mps2 = 0.001197f, /* of a code, at +-4 g */
    .gyro_rads = 0.000305f,  /* of a code, at +-500 dps */
    .temperature_k = 1.0f / 256.0f,
    .temperature_zero_c = 25.0f,
    .period_s = 0.005,
    .values = FOS_VALUES_RAW,
};

/* What it returns is a fos_status, and startup.c hands it to stopped(). */
int main(void)
{
    fos_hub *hub;
    fos_raw_sample raw;
    fos_output output;

    fos_status status = fos_hub_init(memory, sizeof memory, &scales, &hub);
    if (status == FOS_STATUS_OK)
        status = fos_hub_load(hub, model, sizeof model);
    while (status == FOS_STATUS_OK && read_sensor(&raw)) {
        status = fos_hub_update(hub, &raw, &output);
        if (status == FOS_STATUS_OK)
            use_sample(&output);
    }
    return (int)status;
}
