/*
 * Stack that each call takes on the emulated board, and the memory of a hub, of streams and of a store.
 */
#include <stdio.h>
#include <string.h>

#include "fos.h"
#include "model.h"
#include "stack.h"

static uint64_t memory[FOS_HUB_BYTES / 8];
static uint8_t frame[FOS_TELEMETRY_BYTES];
static size_t used;
static fos_hub *hub;
static fos_output output;
static const fos_scales scales = {0.001197f, 0.000305f, 1.0f / 256.0f, 25.0f, 0.005, FOS_VALUES_RAW};
static fos_raw_sample raw = {0, {0, 0, 8192}, {0, 0, -13}, 256, 0, 1};

static fos_status init(void) { return fos_hub_init(memory, sizeof memory, &scales, &hub); }
static fos_status load(void) { return fos_hub_load(hub, model, sizeof model); }
static fos_status update(void) { return fos_hub_update(hub, &raw, &output); }
static fos_status after_a_gap(void)
{
    fos_raw_sample late = raw;
    late.skipped = 1000;
    return fos_hub_update(hub, &late, &output);
}
static fos_status start(void) { return fos_telemetry_start(hub, model, sizeof model, frame, sizeof frame, &used); }
static fos_status sample(void) { return fos_telemetry_sample(hub, frame, sizeof frame, &used); }

static uint64_t streams_memory[FOS_STREAMS_BYTES / 8];
static fos_streams *streams;
static fos_si_sample sample_of_streams;
static fos_si_output si;
static int64_t stamp_ns;

static fos_status streams_init(void)
{
    const fos_stream_periods periods = {5000000, 10000000, 1000000000};
    return fos_streams_init(streams_memory, sizeof streams_memory, &periods, &streams);
}
static fos_status push(void)
{
    const float value[3] = {0.0f, 0.0f, 9.8f};
    fos_status status = fos_streams_gyro(streams, 1, value);
    return status == FOS_STATUS_OK ? fos_streams_accel(streams, 1, value) : status;
}
static fos_status next(void) { return fos_streams_next(streams, &sample_of_streams, &stamp_ns); }
static fos_status update_si(void) { return fos_hub_update_si(hub, &sample_of_streams, &si); }

static uint8_t flash_memory[4 * 4096];
static uint64_t store_memory[FOS_STORE_BYTES / 8];
static uint8_t image[FOS_STORE_IMAGE_BYTES];
static fos_store *store;

static int32_t flash_read(void *context, uint32_t address, uint8_t *bytes, size_t length)
{
    (void)context;
    memcpy(bytes, flash_memory + address, length);
    return 0;
}
static int32_t flash_write(void *context, uint32_t address, const uint8_t *bytes, size_t length)
{
    (void)context;
    memcpy(flash_memory + address, bytes, length);
    return 0;
}
static int32_t flash_erase(void *context, uint32_t address, uint32_t length)
{
    (void)context;
    memset(flash_memory + address, 0xff, length);
    return 0;
}
static fos_status store_init(void)
{
    const fos_flash flash = {NULL, flash_read, flash_write, flash_erase, 0, sizeof flash_memory, 4096};
    return fos_store_init(store_memory, sizeof store_memory, &flash, &store);
}
static fos_status save(void) { return fos_store_save(store, model, sizeof model); }
static fos_status store_load(void) { return fos_store_load(store, image, sizeof image, &used); }

__attribute__((noinline)) static void measure(const char *name, fos_status (*call)(void))
{
    uintptr_t painted = stack_paint();
    fos_status status = call();
    printf("%s: %u bytes of stack%s%s\n", name, (unsigned)stack_used(painted), status == FOS_STATUS_OK ? "" : ", ",
           status == FOS_STATUS_OK ? "" : fos_status_text(status));
}

int main(void)
{
    printf("hub: %u bytes\n", (unsigned)fos_hub_size());
    measure("fos_hub_init", init);
    measure("fos_hub_load", load);
    measure("fos_hub_update", update);
    measure("fos_hub_update after a gap", after_a_gap);
    printf("streams: %u bytes\n", (unsigned)fos_streams_size());
    measure("fos_streams_init", streams_init);
    measure("fos_streams_gyro, fos_streams_accel", push);
    measure("fos_streams_next", next);
    measure("fos_hub_update_si", update_si);
    printf("store: %u bytes\n", (unsigned)fos_store_size());
    measure("fos_store_init", store_init);
    measure("fos_store_save, of nothing", save);
    measure("fos_store_save", save);
    measure("fos_store_load", store_load);
    measure("fos_telemetry_start", start);
    measure("fos_telemetry_sample", sample);
    return 0;
}
