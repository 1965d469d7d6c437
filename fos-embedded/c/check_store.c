/*
 * check_store IMAGE: every function of the store with arguments that it must refuse, on flash of every size of sector,
 * and with functions of the flash that fail at every single call.
 */
#include "check.h"

enum { MAX_FLASH = 8 * 65536, BASE = 0x10000 };

/* Flash whose functions hold their caller to what the header promises them. */
static struct {
    uint8_t *bytes;
    uint32_t size, sector;
    unsigned long calls, fails_at; /* the call that fails, from 1; from then on all do */
} device;

static uint8_t images[2][FOS_STORE_IMAGE_BYTES + 8];
static size_t lengths[2];

static int fails(void *context, uint32_t address, size_t length, uint32_t unit)
{
    EXPECT(context == &device && address >= BASE && address % unit == 0 && length % unit == 0 && length > 0);
    EXPECT(address - BASE + length <= device.size);
    device.calls++;
    return device.fails_at != 0 && device.calls >= device.fails_at;
}

static int32_t flash_read(void *context, uint32_t address, uint8_t *bytes, size_t length)
{
    if (fails(context, address, length, 8))
        return -5;
    memcpy(bytes, device.bytes + (address - BASE), length);
    return 0;
}

static int32_t flash_write(void *context, uint32_t address, const uint8_t *bytes, size_t length)
{
    int cut = fails(context, address, length, 8);
    for (size_t n = 0; n < (cut ? length / 2 : length); n++)
        device.bytes[address - BASE + n] &= bytes[n];
    return cut ? 1 : 0;
}

static int32_t flash_erase(void *context, uint32_t address, uint32_t length)
{
    EXPECT(length == (device.sector > 4096 ? device.sector : 4096));
    int cut = fails(context, address, length, device.sector);
    memset(device.bytes + (address - BASE), 0xff, cut ? length / 2 : length);
    return cut ? INT32_MIN : 0;
}

static fos_flash flash_of(uint32_t sector, uint32_t pages)
{
    device.sector = sector;
    device.size = pages * (sector > 4096 ? sector : 4096);
    device.calls = device.fails_at = 0;
    memset(device.bytes, 0xff, MAX_FLASH);
    return (fos_flash){&device, flash_read, flash_write, flash_erase, BASE, device.size, sector};
}

static fos_store *made(const fos_flash *flash)
{
    fos_store *store = NULL;
    uint8_t *memory = before_guard(fos_store_size());
    memset(memory, 0xa5, fos_store_size());
    EXPECT(fos_store_init(memory, fos_store_size(), flash, &store) == FOS_STATUS_OK && (uint8_t *)store == memory);
    return store;
}

static void drop_store(fos_store *store) { drop((uint8_t *)store, fos_store_size()); }

static void expect_none(void *memory, size_t size, const fos_flash *flash, fos_status status)
{
    fos_store *store = (fos_store *)(void *)&expected;
    EXPECT(fos_store_init(memory, size, flash, &store) == status && store == NULL);
}

static void init_refuses(void)
{
    static uint64_t memory[FOS_STORE_BYTES / 8 + 1];
    uint8_t *bytes = (uint8_t *)memory;
    void *out[2] = {NULL, NULL};
    const fos_flash good = flash_of(4096, 4);
    EXPECT(fos_store_size() > 0 && fos_store_size() <= FOS_STORE_BYTES);
    EXPECT(fos_store_align() > 0 && fos_store_align() <= FOS_STORE_ALIGN && FOS_STORE_BYTES % FOS_STORE_ALIGN == 0);
    EXPECT(fos_store_init(memory, sizeof memory, &good, NULL) == FOS_STATUS_NULL);
    EXPECT(fos_store_init(memory, sizeof memory, &good, (fos_store **)(void *)((uint8_t *)out + 1)) == FOS_STATUS_MISALIGNED);
    EXPECT(out[0] == NULL && out[1] == NULL);
    expect_none(NULL, sizeof memory, &good, FOS_STATUS_NULL);
    expect_none(memory, sizeof memory, NULL, FOS_STATUS_NULL);
    expect_none(memory, SIZE_MAX, &good, FOS_STATUS_ARGUMENT);
    for (size_t size = 0; size < fos_store_size(); size++)
        expect_none(memory, size, &good, FOS_STATUS_NO_ROOM);
    for (size_t off = 1; off < fos_store_align(); off++)
        expect_none(bytes + off, sizeof memory - off, &good, FOS_STATUS_MISALIGNED);
    uint64_t spare[sizeof good / 8 + 2] = {0};
    expect_none(memory, sizeof memory, (const fos_flash *)(const void *)((uint8_t *)spare + 1), FOS_STATUS_MISALIGNED);
    fos_flash wrong = good;
    wrong.read = NULL;
    expect_none(memory, sizeof memory, &wrong, FOS_STATUS_NULL);
    wrong = good;
    wrong.write = NULL;
    expect_none(memory, sizeof memory, &wrong, FOS_STATUS_NULL);
    wrong = good;
    wrong.erase = NULL;
    expect_none(memory, sizeof memory, &wrong, FOS_STATUS_NULL);
    const uint32_t ranges[][3] = {
        /* address, capacity, erase_size */
        {BASE, 4 * 4096, 0},       {BASE, 4 * 4096, 3000},         {BASE, 4 * 4100, 4100},        {BASE + 4, 4 * 4096, 4096},
        {BASE + 8, 4 * 4096, 4096}, {BASE, 3 * 4096, 4096},        {BASE, 4 * 4096 + 8, 4096},    {BASE, 0, 4096},
        {BASE, 4 * 4096, 8192},    {UINT32_MAX - 8191, 4 * 4096, 4096}, {BASE, UINT32_MAX, 4096}, {0, UINT32_MAX, UINT32_MAX},
        {0, 4 * 4096, 4},
    };
    for (size_t n = 0; n < sizeof ranges / sizeof *ranges; n++) {
        wrong = good;
        wrong.address = ranges[n][0];
        wrong.capacity = ranges[n][1];
        wrong.erase_size = ranges[n][2];
        if (n == 12) { /* sectors of one word and less are many of them */
            fos_store *store = NULL;
            EXPECT(fos_store_init(memory, sizeof memory, &wrong, &store) == FOS_STATUS_OK);
            continue;
        }
        expect_none(memory, sizeof memory, &wrong, FOS_STATUS_ARGUMENT);
    }
    EXPECT(device.calls == 0); /* the flash was not looked at */
}

static void expect_loaded(fos_store *store, const uint8_t *image, size_t length)
{
    size_t used = 77;
    uint8_t *buffer = before_guard(length);
    EXPECT(fos_store_load(store, buffer, length, &used) == FOS_STATUS_OK && used == length);
    EXPECT(memcmp(buffer, image, length) == 0);
    drop(buffer, length);
}

static void calls_refuse(void)
{
    const fos_flash flash = flash_of(4096, 6);
    fos_store *store = made(&flash), *odd = (fos_store *)((uint8_t *)store + 1);
    static uint8_t buffer[FOS_STORE_IMAGE_BYTES + 8];
    uint64_t spare[2] = {0};
    size_t used = 9, *odd_used = (size_t *)(void *)((uint8_t *)spare + 1);
    EXPECT(fos_store_save(NULL, images[0], lengths[0]) == FOS_STATUS_NULL);
    EXPECT(fos_store_save(store, NULL, lengths[0]) == FOS_STATUS_NULL);
    EXPECT(fos_store_save(odd, images[0], lengths[0]) == FOS_STATUS_MISALIGNED);
    EXPECT(fos_store_save(store, images[0], SIZE_MAX) == FOS_STATUS_ARGUMENT);
    EXPECT(device.calls == 0);
    for (size_t length = 0; length < lengths[0]; length++) {
        uint8_t *shorter = before_guard(length);
        memcpy(shorter, images[0], length);
        EXPECT(fos_store_save(store, shorter, length) == FOS_STATUS_TRUNCATED);
        drop(shorter, length);
    }
    EXPECT(fos_store_save(store, images[0], lengths[0] + 1) == FOS_STATUS_TRAILING_BYTES);
    images[0][lengths[0] / 2] ^= 1;
    EXPECT(fos_store_save(store, images[0], lengths[0]) == FOS_STATUS_DAMAGED);
    images[0][lengths[0] / 2] ^= 1;
    EXPECT(device.calls == 0); /* nothing of that was written */

    fos_status (*const loads[])(fos_store *, uint8_t *, size_t, size_t *) = {fos_store_load, fos_store_load_previous};
    for (int n = 0; n < 2; n++) {
        EXPECT(loads[n](store, buffer, sizeof buffer, NULL) == FOS_STATUS_NULL);
        EXPECT(loads[n](store, buffer, sizeof buffer, odd_used) == FOS_STATUS_MISALIGNED);
        EXPECT(loads[n](NULL, buffer, sizeof buffer, &used) == FOS_STATUS_NULL && used == 0);
        used = 9;
        EXPECT(loads[n](odd, buffer, sizeof buffer, &used) == FOS_STATUS_MISALIGNED && used == 0);
        used = 9;
        EXPECT(loads[n](store, NULL, sizeof buffer, &used) == FOS_STATUS_NULL && used == 0);
        used = 9;
        EXPECT(loads[n](store, buffer, SIZE_MAX, &used) == FOS_STATUS_ARGUMENT && used == 0);
        used = 9;
        EXPECT(loads[n](store, buffer, sizeof buffer, &used) == FOS_STATUS_NO_MODEL && used == 0);
    }
    EXPECT(fos_store_save(store, images[0], lengths[0]) == FOS_STATUS_OK);
    EXPECT(fos_store_load_previous(store, buffer, sizeof buffer, &used) == FOS_STATUS_NO_MODEL && used == 0);
    EXPECT(fos_store_save(store, images[1], lengths[1]) == FOS_STATUS_OK);
    EXPECT(fos_store_load_previous(store, buffer, sizeof buffer, &used) == FOS_STATUS_OK && used == lengths[0]);
    EXPECT(memcmp(buffer, images[0], used) == 0);
    for (size_t capacity = 0; capacity < lengths[1]; capacity += 7) {
        uint8_t *room = before_guard(capacity);
        EXPECT(fos_store_load(store, room, capacity, &used) == FOS_STATUS_NO_ROOM && used == 0);
        drop(room, capacity);
    }
    expect_loaded(store, images[1], lengths[1]);
    /* what is stored outlives the store */
    drop_store(store);
    store = made(&flash);
    expect_loaded(store, images[1], lengths[1]);
    drop_store(store);
}

/* Sectors that divide a page, are one, or are larger. */
static void every_sector(void)
{
    const uint32_t sectors[] = {8, 256, 512, 2048, 4096, 4104, 8192, 65536};
    for (size_t n = 0; n < sizeof sectors / sizeof *sectors; n++) {
        fos_flash flash = flash_of(sectors[n], 4);
        flash.address = (BASE + sectors[n] - 1) / sectors[n] * sectors[n];
        device.size += flash.address - BASE;
        fos_store *store = made(&flash);
        for (int update = 0; update < 100; update++) {
            EXPECT(fos_store_save(store, images[update % 2], lengths[update % 2]) == FOS_STATUS_OK);
            expect_loaded(store, images[update % 2], lengths[update % 2]);
        }
        drop_store(store);
    }
}

/* From the n-th call on every function fails, as if the power were gone; then it comes back. */
static void every_call_fails(void)
{
    static uint8_t whole[MAX_FLASH];
    unsigned long failed = 0, old = 0;
    const fos_flash flash = flash_of(2048, 4);
    fos_store *store = made(&flash);
    for (int update = 0; update < 40; update++) {
        const uint8_t *before = images[update % 2], *after = images[(update + 1) % 2];
        size_t before_length = lengths[update % 2], after_length = lengths[(update + 1) % 2];
        EXPECT(fos_store_save(store, before, before_length) == FOS_STATUS_OK);
        memcpy(whole, device.bytes, device.size);
        for (unsigned long at = 1;; at++) {
            memcpy(device.bytes, whole, device.size);
            device.calls = 0;
            device.fails_at = at;
            fos_status status = fos_store_save(store, after, after_length);
            if (status == FOS_STATUS_OK)
                break;
            EXPECT(status == FOS_STATUS_FLASH);
            failed++;
            size_t used = 9;
            uint8_t *room = before_guard(FOS_STORE_IMAGE_BYTES);
            EXPECT(fos_store_load(store, room, FOS_STORE_IMAGE_BYTES, &used) == FOS_STATUS_FLASH && used == 0);
            EXPECT(fos_store_load_previous(store, room, FOS_STORE_IMAGE_BYTES, &used) == FOS_STATUS_FLASH && used == 0);
            device.fails_at = 0;
            EXPECT(fos_store_load(store, room, FOS_STORE_IMAGE_BYTES, &used) == FOS_STATUS_OK);
            int is_old = used == before_length && memcmp(room, before, used) == 0;
            EXPECT(is_old || (used == after_length && memcmp(room, after, used) == 0));
            old += (unsigned long)is_old;
            /* and it goes on */
            EXPECT(fos_store_save(store, before, before_length) == FOS_STATUS_OK);
            drop(room, FOS_STORE_IMAGE_BYTES);
        }
        device.fails_at = 0;
        memcpy(device.bytes, whole, device.size);
    }
    EXPECT(failed > 1000 && old > 0 && old < failed);
    printf("store: %lu saves failed at every call in turn, %lu left the image before, the others the new one\n", failed, old);
    drop_store(store);
}

/* Whatever is in the flash, it is at most no image. */
static void random_contents(void)
{
    const fos_flash flash = flash_of(4096, 4);
    fos_store *store = made(&flash);
    static uint8_t buffer[FOS_STORE_IMAGE_BYTES], whole[4 * 4096];
    EXPECT(fos_store_save(store, images[0], lengths[0]) == FOS_STATUS_OK);
    EXPECT(fos_store_save(store, images[1], lengths[1]) == FOS_STATUS_OK);
    memcpy(whole, device.bytes, sizeof whole);
    unsigned found = 0;
    for (int n = 0; n < 20000; n++) {
        size_t used;
        memcpy(device.bytes, whole, sizeof whole);
        if (n % 10 == 0)
            for (size_t k = 0; k < sizeof whole; k++)
                device.bytes[k] = (uint8_t)random_bits();
        /* mostly where headers are */
        for (uint32_t left = random_bits() % 16; left > 0; left--) {
            uint32_t place = random_bits() % 4 * 4096 + random_bits() % (random_bits() % 2 ? 64 : 4096);
            device.bytes[place] = random_bits() % 2 ? (uint8_t)random_bits() : (uint8_t)(device.bytes[place] & random_bits());
        }
        fos_status status = fos_store_load(store, buffer, sizeof buffer, &used);
        EXPECT(status == FOS_STATUS_OK || status == FOS_STATUS_NO_MODEL || status == FOS_STATUS_FLASH);
        if (status == FOS_STATUS_OK) {
            EXPECT((used == lengths[0] && memcmp(buffer, images[0], used) == 0) ||
                   (used == lengths[1] && memcmp(buffer, images[1], used) == 0));
            found++;
        }
        status = fos_store_save(store, images[0], lengths[0]);
        EXPECT(status == FOS_STATUS_OK);
        expect_loaded(store, images[0], lengths[0]);
    }
    printf("store: of 20000 damaged contents %u still had an image, all took a new one\n", found);
    drop_store(store);
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL) {
        printf("usage: check_store IMAGE\n");
        return 2;
    }
    lengths[0] = fread(images[0], 1, sizeof images[0] - 1, file);
    fclose(file);
    /* another one: of a sensor with another name */
    memcpy(images[1], images[0], sizeof images[1]);
    lengths[1] = lengths[0];
    size_t place = 20;
    while (place < lengths[1] && memcmp(images[1] + place, "simulated", 9) != 0)
        place++;
    EXPECT(place < lengths[1]);
    images[1][place] = 'S';
    seal(images[1], lengths[1]);
    device.bytes = before_guard(MAX_FLASH);
    init_refuses();
    calls_refuse();
    every_sector();
    every_call_fails();
    random_contents();
    printf("store: %lu bytes, %lu checks hold\n", (unsigned long)fos_store_size(), expected);
    return 0;
}
