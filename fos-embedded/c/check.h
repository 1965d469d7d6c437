/*
 * What the programs share that call everything wrongly.
 *
 * Memory that is handed over ends at a page that must not be touched, so that a byte too far is a crash. Runs on a host
 * with POSIX; built with the address and undefined behaviour sanitizers by `.ci/c host`.
 */
#ifndef CHECK_H
#define CHECK_H

#define _DEFAULT_SOURCE
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fos.h"

#define EXPECT(condition) expect((condition), #condition, __FILE__, __LINE__)

static unsigned long expected;

static void expect(int holds, const char *condition, const char *file, int line)
{
    expected++;
    if (!holds) {
        printf("%s:%d: does not hold: %s\n", file, line, condition);
        exit(1);
    }
}

/* `length` bytes up to a page that must not be touched; aligned as the length is. */
static uint8_t *before_guard(size_t length)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    size_t pages = (length + page - 1) / page + 1;
    uint8_t *start = mmap(NULL, (pages + 1) * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (start == MAP_FAILED || mprotect(start + pages * page, page, PROT_NONE) != 0) {
        perror("mmap");
        exit(2);
    }
    return start + pages * page - length;
}

static void drop(uint8_t *bytes, size_t length)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    size_t pages = (length + page - 1) / page + 1;
    munmap(bytes + length - pages * page, (pages + 1) * page);
}

static uint32_t random_bits(void)
{
    static uint64_t state = 1; /* Knuth's linear congruential generator: the same on every run */
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(state >> 32);
}

static const float ODD[] = {0.0f, -0.0f, 1e-45f, FLT_MAX, -FLT_MAX, NAN, INFINITY, -INFINITY};
enum { N_ODD = sizeof ODD / sizeof *ODD };

static inline uint32_t crc32(uint32_t crc, const uint8_t *bytes, size_t length)
{
    while (length-- > 0) {
        crc ^= *bytes++;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? UINT32_C(0xedb88320) : 0);
    }
    return crc;
}

/* what the checksum of an image covers is everything but its own four bytes, 16 to 19 */
static inline void seal(uint8_t *bytes, size_t length)
{
    uint32_t crc = ~crc32(crc32(UINT32_MAX, bytes, 16), bytes + 20, length - 20);
    for (int n = 0; n < 4; n++)
        bytes[16 + n] = (uint8_t)(crc >> (8 * n));
}

#endif
