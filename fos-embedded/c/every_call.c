/*
 * Calls every function with arguments of which the compiler knows nothing. Linked with an archive whose panic handler
 * calls a function that is defined nowhere, it links only if no call can reach a panic: but for the store, which is over
 * a library of which the linker cannot tell (WITHOUT_STORE). Never run.
 */
#include "fos.h"

struct arguments {
    void *memory;
    size_t size, k;
    fos_hub *hub;
    fos_scales *scales;
    const fos_raw_sample *raw;
    fos_output *output;
    fos_si_sample *si_sample;
    fos_si_output *si_output;
    fos_streams *streams;
    const fos_stream_periods *periods;
    fos_stream_counts *counts;
    int64_t *stamp_ns;
    fos_store *store;
    const fos_flash *flash;
    uint8_t *buffer;
    uint64_t now_us;
    float *number;
    int32_t status;
    uint16_t bit;
};

struct arguments *volatile arguments;
const char *volatile kept;

#ifdef PANIC_ON_PURPOSE
int32_t fos_panic_on_purpose(size_t index); /* in no other archive */
#endif

int main(void)
{
    struct arguments a = *arguments;
    kept = fos_status_text(a.status);
    kept = fos_validity_text(a.bit);
    kept = fos_version();
    a.k += fos_api_version() + fos_hub_size() + fos_hub_align() + fos_streams_size() + fos_streams_align();
    int32_t status = fos_scales_of_full_scale(*a.number, *a.number, (double)*a.number, a.buffer[0], a.scales);
    status |= fos_hub_init(a.memory, a.size, a.scales, &a.hub);
    status |= fos_hub_load(a.hub, a.buffer, a.size);
    status |= fos_hub_update(a.hub, a.raw, a.output);
    status |= fos_hub_update_si(a.hub, a.si_sample, a.si_output);
    status |= fos_hub_give(a.hub, (fos_quantity)a.bit, *a.number);
    status |= fos_hub_give_application(a.hub, a.k, *a.number);
    status |= fos_hub_set_motion(a.hub, (fos_motion)a.bit);
    status |= fos_hub_clock(a.hub, a.now_us);
    status |= fos_hub_rate_hz(a.hub, a.number);
    status |= fos_hub_drift(a.hub, a.k, a.buffer);
    status |= fos_hub_restart_watch(a.hub);
    status |= fos_telemetry_start(a.hub, a.buffer, a.size, a.buffer, a.size, &a.size);
    status |= fos_telemetry_sample(a.hub, a.buffer, a.size, &a.size);
    status |= fos_streams_init(a.memory, a.size, a.periods, &a.streams);
    status |= fos_streams_set_periods(a.streams, a.periods);
    status |= fos_streams_gyro(a.streams, *a.stamp_ns, a.number);
    status |= fos_streams_accel(a.streams, *a.stamp_ns, a.number);
    status |= fos_streams_temperature(a.streams, *a.stamp_ns, *a.number);
    status |= fos_streams_next(a.streams, a.si_sample, a.stamp_ns);
    status |= fos_streams_flush(a.streams, a.si_sample, a.stamp_ns);
    status |= fos_streams_counts(a.streams, a.counts);
    status |= fos_image_for_unit(a.buffer, a.size, a.buffer, a.size, a.buffer, a.size, &a.size);
#ifndef WITHOUT_STORE
    a.k += fos_store_size() + fos_store_align();
    status |= fos_store_init(a.memory, a.size, a.flash, &a.store);
    status |= fos_store_save(a.store, a.buffer, a.size);
    status |= fos_store_load(a.store, a.buffer, a.size, &a.size);
    status |= fos_store_load_previous(a.store, a.buffer, a.size, &a.size);
#endif
#ifdef PANIC_ON_PURPOSE
    status |= fos_panic_on_purpose(a.k);
#endif
    return status;
}
