#include "fos_nanoapp_image.h"

static uint64_t checking_memory[FOS_HUB_BYTES / 8]; /* of a second hub, which says whether an image is sound */
static uint8_t arriving[FOS_NANOAPP_IMAGE_BYTES];
static size_t whole_bytes, arrived;
static bool refuses_parts; /* the image has been answered, whatever still comes of it */

void fos_image_start(void)
{
    whole_bytes = arrived = 0;
    refuses_parts = false;
}

const uint8_t *fos_image_arrived(size_t *length)
{
    *length = whole_bytes;
    return arriving;
}

static fos_status check(const fos_scales *scales)
{
    fos_hub *hub;
    fos_status status = fos_hub_init(checking_memory, sizeof checking_memory, scales, &hub);
    return status == FOS_STATUS_OK ? fos_hub_load(hub, arriving, whole_bytes) : status;
}

bool fos_image_take_part(const uint8_t *bytes, size_t length, const fos_scales *scales, fos_status *status)
{
    enum { HEADER = 8 };
    uint32_t whole = length >= HEADER ? (uint32_t)fos_message_get(bytes, 4) : 0;
    uint32_t begins = length >= HEADER ? (uint32_t)fos_message_get(bytes + 4, 4) : 0;
    size_t n = length >= HEADER ? length - HEADER : 0;
    if (begins == 0) {
        refuses_parts = false;
        whole_bytes = whole;
        arrived = 0;
    } else if (refuses_parts) {
        return false;
    }
    *status = FOS_STATUS_OK;
    if (whole > sizeof arriving)
        *status = FOS_STATUS_NO_ROOM;
    else if (length < HEADER || whole != whole_bytes || begins != arrived || n > whole - begins)
        *status = FOS_STATUS_ARGUMENT;
    if (*status == FOS_STATUS_OK) {
        memcpy(arriving + begins, bytes + HEADER, n);
        arrived += n;
        if (arrived < whole)
            return false;
        *status = check(scales);
    }
    refuses_parts = true;
    return true;
}
