/*
 * From reset to main() on the emulated board, with newlib's semihosting (--specs=rdimon.specs): argv is what QEMU is
 * given, files are the host's, the exit code is main()'s.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern uint32_t data_start[], data_end[], data_stored[], bss_start[], bss_end[], stack_top[];
extern void initialise_monitor_handles(void);
extern void __libc_init_array(void);
extern int main(int argc, char **argv);
void reset(void);
void _init(void);
void _fini(void);

enum { SYS_GET_CMDLINE = 0x15, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026, MAX_ARGUMENTS = 8 };

static int semihosting(int operation, const void *block)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/* whatever should not happen ends the program, and QEMU with it */
static void fault(void)
{
    const uint32_t block[2] = {APPLICATION_EXIT, 102};
    semihosting(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}

/* newlib asks for them; the arrays that they belong to are empty in C */
void _init(void) {}
void _fini(void) {}

static int arguments(char **argv)
{
    static char line[4096];
    const struct {
        char *start;
        uint32_t length;
    } block = {line, sizeof line};
    int argc = 0;
    if (semihosting(SYS_GET_CMDLINE, &block) != 0)
        return 0;
    for (char *word = strtok(line, " "); word != NULL && argc < MAX_ARGUMENTS; word = strtok(NULL, " "))
        argv[argc++] = word;
    return argc;
}

void reset(void)
{
    static char *argv[MAX_ARGUMENTS + 1];
    *(volatile uint32_t *)0xe000ed88 |= 0xf << 20; /* CPACR: the floating-point unit is on */
    __asm__ volatile("dsb\nisb");
    memcpy(data_start, data_stored, (size_t)((char *)data_end - (char *)data_start));
    memset(bss_start, 0, (size_t)((char *)bss_end - (char *)bss_start));
    initialise_monitor_handles();
    __libc_init_array();
    exit(main(arguments(argv), argv));
}

/* as the core has it: the stack, reset, then NMI, HardFault and the other faults */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vectors = {stack_top, {reset, fault, fault, fault, fault, fault}};
