/*
 * Stack that each call takes on the emulated board, and the memory of a hub. The stack below is painted before a call;
 * what has changed after it was used.
 */
#include <stdio.h>

#include "fos.h"
#include "model.h"

enum { PAINTED = 4096, PAINT = 0xa5 };

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

/* The frame of this function is the painted stack: what is called next lies there. */
__attribute__((noinline)) static uintptr_t paint(void)
{
    volatile uint8_t stack[PAINTED];
    for (size_t n = 0; n < PAINTED; n++)
        stack[n] = PAINT;
    return (uintptr_t)stack;
}

__attribute__((noinline)) static void measure(const char *name, fos_status (*call)(void))
{
    volatile uint8_t *bottom = (volatile uint8_t *)paint();
    fos_status status = call();
    size_t left = 0;
    while (left < PAINTED && bottom[left] == PAINT)
        left++;
    printf("%s: %u bytes of stack%s%s\n", name, (unsigned)(PAINTED - left), status == FOS_STATUS_OK ? "" : ", ",
           status == FOS_STATUS_OK ? "" : fos_status_text(status));
}

int main(void)
{
    printf("hub: %u bytes\n", (unsigned)fos_hub_size());
    measure("fos_hub_init", init);
    measure("fos_hub_load", load);
    measure("fos_hub_update", update);
    measure("fos_hub_update after a gap", after_a_gap);
    measure("fos_telemetry_start", start);
    measure("fos_telemetry_sample", sample);
    return 0;
}
