/*
 * From reset to main() on any Cortex-M, without a C library: what cortex-m.ld lays out is copied and cleared. The
 * part's own interrupts come behind the 16 vectors of the core; a vendor's start-up file has them, and takes the place
 * of this one.
 */
#include <stdint.h>

extern uint32_t data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern const uint32_t data_stored[];
int main(void);
void reset(void);
void stopped(int status);
void unexpected(void);

/* main() has returned: a function of this name elsewhere takes the place of this one */
__attribute__((weak)) void stopped(int status)
{
    (void)status;
    for (;;) {
    }
}

/* a fault, or an interrupt that nobody asked for */
__attribute__((weak)) void unexpected(void)
{
    for (;;) {
    }
}

void reset(void)
{
    uint32_t *to;
    const uint32_t *from = data_stored;
#if defined(__ARM_FP)
    *(volatile uint32_t *)0xe000ed88 |= 0xfu << 20; /* CPACR: the floating-point unit is on */
    __asm__ volatile("dsb\nisb" ::: "memory");
#endif
    for (to = data_start; to != data_end; to++)
        *to = *from++;
    for (to = bss_start; to != bss_end; to++)
        *to = 0;
    stopped(main());
}

/* as the core has it: the stack, reset, then NMI, HardFault and the others */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vectors = {stack_top,
             {reset, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
              unexpected, unexpected, unexpected, unexpected, unexpected, unexpected}};
