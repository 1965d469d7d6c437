/*
 * Stack that a call takes: what lies below is painted before it; what has changed after it was used.
 */
#ifndef FOS_STACK_H
#define FOS_STACK_H

#include <stddef.h>
#include <stdint.h>

enum { STACK_PAINTED = 12288, STACK_PAINT = 0xa5 };

/* The frame of this function is the painted stack: what is called next lies there. */
__attribute__((noinline)) static uintptr_t stack_paint(void)
{
    volatile uint8_t stack[STACK_PAINTED];
    for (size_t n = 0; n < STACK_PAINTED; n++)
        stack[n] = STACK_PAINT;
    return (uintptr_t)stack;
}

/* Bytes of it that were used since. */
static size_t stack_used(uintptr_t painted)
{
    const volatile uint8_t *bottom = (const volatile uint8_t *)painted;
    size_t left = 0;
    while (left < STACK_PAINTED && bottom[left] == STACK_PAINT)
        left++;
    return STACK_PAINTED - left;
}

#endif
