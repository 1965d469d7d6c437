/*
 * What the sensor hub of a phone needs: values in SI units, streams with stamps of their own, a model in flash.
 *
 * The flash is memory here; gyros at 200 Hz, accelerometers at 100 Hz, a thermometer at 1 Hz lie on a table.
 */
#include <float.h>
#include <stdio.h>
#include <string.h>

#include "fos.h"
#include "model.h" /* static const unsigned char model[]: as came over the air */

static uint64_t hub_memory[FOS_HUB_BYTES / 8], streams_memory[FOS_STREAMS_BYTES / 8], store_memory[FOS_STORE_BYTES / 8];
static uint8_t image[FOS_STORE_IMAGE_BYTES];

/* The driver's part: three functions that return 0 when all is done. */
static uint8_t flash_memory[4 * 4096];

static int32_t flash_read(void *context, uint32_t address, uint8_t *bytes, size_t length)
{
    memcpy(bytes, (uint8_t *)context + address, length);
    return 0;
}

static int32_t flash_write(void *context, uint32_t address, const uint8_t *bytes, size_t length)
{
    memcpy((uint8_t *)context + address, bytes, length);
    return 0;
}

static int32_t flash_erase(void *context, uint32_t address, uint32_t length)
{
    memset((uint8_t *)context + address, 0xff, length);
    return 0;
}

static fos_status load_model(fos_hub *hub)
{
    const fos_flash flash = {
        .context = flash_memory,
        .read = flash_read,
        .write = flash_write,
        .erase = flash_erase,
        .address = 0,
        .capacity = sizeof flash_memory,
        .erase_size = 4096,
    };
    fos_store *store;
    size_t length;
    fos_status status = fos_store_init(store_memory, sizeof store_memory, &flash, &store);
    if (status == FOS_STATUS_OK)
        status = fos_store_save(store, model, sizeof model); /* when one comes over the air */
    if (status == FOS_STATUS_OK)
        status = fos_store_load(store, image, sizeof image, &length); /* when the device starts */
    return status == FOS_STATUS_OK ? fos_hub_load(hub, image, length) : status;
}

int main(void)
{
    const fos_stream_periods periods = {.gyro_ns = 5000000, .accel_ns = 10000000, .temperature_ns = 1000000000};
    fos_scales scales;
    fos_hub *hub;
    fos_streams *streams;
    fos_si_sample sample;
    fos_si_output si;
    int64_t stamp_ns;
    unsigned given = 0;

    /* +-4 g; what the full scale of the gyros is nobody says */
    fos_status status = fos_scales_of_full_scale(39.2266f, FLT_MAX, 0.005, FOS_VALUES_RAW, &scales);
    if (status == FOS_STATUS_OK)
        status = fos_hub_init(hub_memory, sizeof hub_memory, &scales, &hub);
    if (status == FOS_STATUS_OK)
        status = fos_streams_init(streams_memory, sizeof streams_memory, &periods, &streams);
    if (status == FOS_STATUS_OK)
        status = load_model(hub);
    if (status != FOS_STATUS_OK) {
        printf("no model: %s\n", fos_status_text(status));
        return 1;
    }
    memset(&si, 0, sizeof si);
    for (int64_t n = 0; n < 1000; n++) {
        const float rate[3] = {-0.004f, -0.004f, -0.004f + 0.0005f * (float)(n % 5)};
        const float force[3] = {0.03f, 0.0f, 9.8366f + 0.005f * (float)(n % 3)};
        /* each when it comes; a sample that is not taken is counted */
        if (n % 200 == 0)
            (void)fos_streams_temperature(streams, n * 5000000, 26.0f);
        if (n % 2 == 0)
            (void)fos_streams_accel(streams, n * 5000000 + 1000000, force);
        (void)fos_streams_gyro(streams, n * 5000000, rate);
        while (fos_streams_next(streams, &sample, &stamp_ns) == FOS_STATUS_OK) {
            (void)fos_hub_give(hub, FOS_QUANTITY_SUPPLY_V, 3.8f); /* if the model wants it */
            (void)fos_hub_update_si(hub, &sample, &si);
            given++;
        }
    }
    printf("%u samples: gyro z %.6f rad/s, bias %.6f rad/s, corrected %.6f rad/s\n", given,
           (double)si.output.measured[FOS_GZ], (double)si.predicted[FOS_GZ], (double)si.output.corrected[FOS_GZ]);
    return given > 990 && si.output.temperature_c == 26.0f ? 0 : 1;
}
