/* What an application needs: memory, scales, a model, and a call for every sample. */
#include <stdio.h>

#include "fos.h"
#include "model.h" /* static const unsigned char model[]: of `xxd -i` or the like, from a model image */

static uint64_t memory[FOS_HUB_BYTES / 8];

/* The driver's part: here, a sensor that lies on a table at 26 degrees Celsius. */
static void read_sensor(fos_raw_sample *raw)
{
    static int16_t noise = 0;
    noise = (int16_t)((noise * 5 + 3) % 16);
    *raw = (fos_raw_sample){.temperature = 256, .has_temperature = 1};
    for (int axis = 0; axis < 3; axis++) {
        raw->accel[axis] = (int16_t)((axis == 2 ? 8192 : 0) + noise);
        raw->gyro[axis] = (int16_t)(noise - 20);
    }
}

int main(void)
{
    const fos_scales scales = {
        .accel_mps2 = 0.001197f, /* of a code, at +-4 g */
        .gyro_rads = 0.000305f,  /* of a code, at +-500 dps */
        .temperature_k = 1.0f / 256.0f,
        .temperature_zero_c = 25.0f,
        .period_s = 0.005,
        .values = FOS_VALUES_RAW,
    };
    fos_hub *hub;
    fos_raw_sample raw;
    fos_output output;

    fos_status status = fos_hub_init(memory, sizeof memory, &scales, &hub);
    if (status == FOS_STATUS_OK)
        status = fos_hub_load(hub, model, sizeof model);
    if (status != FOS_STATUS_OK) {
        printf("no model: %s\n", fos_status_text(status));
        return 1;
    }
    for (int n = 0; n < 1000; n++) {
        read_sensor(&raw);
        (void)fos_hub_give(hub, FOS_QUANTITY_SUPPLY_V, 3.3f); /* if the model wants it */
        (void)fos_hub_update(hub, &raw, &output);             /* refuses NULL only */
    }
    printf("fos %s: gyro z %.6f rad/s, corrected %.6f rad/s", fos_version(), (double)output.measured[FOS_GZ],
           (double)output.corrected[FOS_GZ]);
    for (unsigned bit = 1; bit <= FOS_VALIDITY_AWAY_FROM_GRAVITY; bit *= 2)
        if (output.validity[FOS_GZ] & bit)
            printf(", %s", fos_validity_text((uint16_t)bit));
    printf("\n");
    return 0;
}
