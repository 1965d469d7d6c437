/*
 * What the nanoapp and its host say to each other: the type of a message, and its bytes, little-endian, without gaps.
 *
 * The host does not wait for an answer before it sends the next message; answers come in the order of the commands.
 */
#ifndef FOS_NANOAPP_MESSAGES_H
#define FOS_NANOAPP_MESSAGES_H

#include <stdint.h>
#include <string.h>

/* The nanoapp, as the host addresses it. The upper five bytes are the vendor's: replace them by your own. */
#define FOS_NANOAPP_ID UINT64_C(0x666f730000000001)

/* Version of this layout and of the nanoapp: major, minor, and 16 bits of patch. */
#define FOS_NANOAPP_VERSION UINT32_C(0x00010000)

/* A model image has at most so many bytes; one that is longer is refused. */
#ifndef FOS_NANOAPP_IMAGE_BYTES
#define FOS_NANOAPP_IMAGE_BYTES 4096
#endif

/*
 * To the nanoapp. Each but FOS_MESSAGE_MODEL has one answer; a model has one after its last part, or after the part
 * that cannot be taken.
 */

/*
 * A part of a model image: u32 bytes of the whole image, u32 where this part begins in it, the bytes of the part. Parts
 * come in order; one that begins at 0 starts anew, whatever came before. The image is checked whole before the model
 * that runs is given up.
 */
#define FOS_MESSAGE_MODEL UINT32_C(0x101)

/* What the nanoapp does: no bytes. */
#define FOS_MESSAGE_STATUS UINT32_C(0x102)

/* u8: 1 sends every sample as telemetry, 0 (as at first) none. */
#define FOS_MESSAGE_TELEMETRY UINT32_C(0x103)

/* u8: a FOS_MOTION_... of fos.h: whether the phone moves, where the host knows. */
#define FOS_MESSAGE_MOTION UINT32_C(0x104)

/* From the nanoapp. */

/*
 * The bias, to be subtracted from what was measured from its stamp on until the next:
 *
 *     i64     stamp of the sample, ns, as the sensors'
 *     f32[6]  accelerometer x y z, m/s^2; gyro x y z, rad/s; finite
 *     u16[6]  what speaks against each: FOS_VALIDITY_... of fos.h
 *     u16     FOS_FAULT_... of fos.h
 *     u8      1 if the phone counts as still
 *     u8      1 if the model has stopped fitting on at least one axis
 */
#define FOS_MESSAGE_BIAS UINT32_C(0x201)
#define FOS_MESSAGE_BIAS_BYTES 48

/* Frames of telemetry, one after the other and all of them whole: what `fos record` reads. */
#define FOS_MESSAGE_FRAMES UINT32_C(0x202)

/*
 * An answer. It also comes without a command: when the nanoapp has started, and whenever the rate of the gyro leaves
 * the model's or comes back to it.
 *
 *     u32  type of the command; 0 without one
 *     i32  fos_status of fos.h: what the command came to; without one, what the hub says of the model
 *     u32  FOS_NANOAPP_VERSION
 *     u32  bytes of the image that runs; 0: none
 *     u32  checksum of that image: bytes 16 to 19 of it
 *     u32  interval of the gyro as CHRE says, ns; 0: there is no gyro, or it is off
 *     u32  rows that went through the hub; this and the counters that follow wrap, and start at 0 with the nanoapp
 *     u32  readings that were refused: not finite, or back in time
 *     u32  messages that could not be sent
 *     u32  models taken
 *     u32  models refused
 *     u32  sensors there are: bits FOS_NANOAPP_SENSOR_...
 */
#define FOS_MESSAGE_ANSWER UINT32_C(0x203)
#define FOS_MESSAGE_ANSWER_BYTES 48

#define FOS_NANOAPP_SENSOR_GYRO UINT32_C(1)
#define FOS_NANOAPP_SENSOR_ACCEL UINT32_C(2)
#define FOS_NANOAPP_SENSOR_GYRO_TEMPERATURE UINT32_C(4)
#define FOS_NANOAPP_SENSOR_ACCEL_TEMPERATURE UINT32_C(8)

/* Puts the lowest `n` bytes of a number, and returns what follows them. */
static inline uint8_t *fos_message_put(uint8_t *to, uint64_t value, int n)
{
    for (; n > 0; n--, value >>= 8)
        *to++ = (uint8_t)(value & 0xff);
    return to;
}

static inline uint8_t *fos_message_put_float(uint8_t *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return fos_message_put(to, bits, 4);
}

/* The number in `n` bytes. */
static inline uint64_t fos_message_get(const uint8_t *from, int n)
{
    uint64_t value = 0;
    while (n-- > 0)
        value = value << 8 | from[n];
    return value;
}

static inline float fos_message_get_float(const uint8_t *from)
{
    uint32_t bits = (uint32_t)fos_message_get(from, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
