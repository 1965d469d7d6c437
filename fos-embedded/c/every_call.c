/*
 * Calls every function with arguments of which the compiler knows nothing. Linked with an archive whose panic handler
 * calls a function that is defined nowhere, it links only if no call can reach a panic. Never run.
 */
#include "fos.h"

struct arguments {
    void *memory;
    size_t size, k;
    fos_hub *hub;
    const fos_scales *scales;
    const fos_raw_sample *raw;
    fos_output *output;
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
    a.k = fos_api_version() + fos_hub_size() + fos_hub_align() + a.k;
    int32_t status = fos_hub_init(a.memory, a.size, a.scales, &a.hub);
    status |= fos_hub_load(a.hub, a.buffer, a.size);
    status |= fos_hub_update(a.hub, a.raw, a.output);
    status |= fos_hub_give(a.hub, (fos_quantity)a.bit, *a.number);
    status |= fos_hub_give_application(a.hub, a.k, *a.number);
    status |= fos_hub_set_motion(a.hub, (fos_motion)a.bit);
    status |= fos_hub_clock(a.hub, a.now_us);
    status |= fos_hub_rate_hz(a.hub, a.number);
    status |= fos_hub_drift(a.hub, a.k, a.buffer);
    status |= fos_hub_restart_watch(a.hub);
    status |= fos_telemetry_start(a.hub, a.buffer, a.size, a.buffer, a.size, &a.size);
    status |= fos_telemetry_sample(a.hub, a.buffer, a.size, &a.size);
#ifdef PANIC_ON_PURPOSE
    status |= fos_panic_on_purpose(a.k);
#endif
    return status;
}
