/*
 * Throws events at the nanoapp: any order, any count, any stamp, any float, any message; sensors that are not there, a
 * transport that takes nothing or gives nothing back, end and start. For libFuzzer; model.h has the image of a model as an
 * array.
 *
 * What must hold: every bias is finite and every message is as fos_nanoapp_messages.h says; no message is changed before it
 * is given back, none is longer than the host takes. The sanitizers watch the memory.
 */
#include <chre.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fos.h"
#include "fos_nanoapp_messages.h"
#include "model.h"

enum { SENSORS = 4, PENDING = 64, MOST_READINGS = 200, MOST_BYTES = 600 };

static const uint8_t TYPES[SENSORS] = {
    CHRE_SENSOR_TYPE_UNCALIBRATED_GYROSCOPE,
    CHRE_SENSOR_TYPE_UNCALIBRATED_ACCELEROMETER,
    CHRE_SENSOR_TYPE_GYROSCOPE_TEMPERATURE,
    CHRE_SENSOR_TYPE_ACCELEROMETER_TEMPERATURE,
};

static void require(bool holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "does not hold: %s\n", what);
        abort();
    }
}

/* The input, from its start; zeros when it is over. */
static const uint8_t *input;
static size_t left;

static uint8_t byte(void)
{
    if (left == 0)
        return 0;
    left--;
    return *input++;
}

static uint64_t raw(int bytes)
{
    uint64_t value = 0;
    while (bytes-- > 0)
        value = value << 8 | byte();
    return value;
}

/* The hub that the nanoapp runs in. */
static uint8_t there;
static bool takes_nothing, gives_nothing_back;
static struct {
    void *bytes;
    size_t length;
    uint32_t sum;
    chreMessageFreeFunction *give_back;
} pending[PENDING];
static int n_pending;
static unsigned long n_bias, n_frames; /* messages */

static uint32_t sum_of(const uint8_t *bytes, size_t length)
{
    uint32_t sum = 0;
    while (length-- > 0)
        sum = sum * 31 + *bytes++;
    return sum;
}

static void give_back(void)
{
    while (n_pending > 0) {
        n_pending--;
        require(sum_of(pending[n_pending].bytes, pending[n_pending].length) == pending[n_pending].sum,
                "a message stays as it is until it is given back");
        pending[n_pending].give_back(pending[n_pending].bytes, pending[n_pending].length);
    }
}

bool chreSensorFindDefault(uint8_t type, uint32_t *handle)
{
    for (uint32_t sensor = 0; sensor < SENSORS; sensor++) {
        if (TYPES[sensor] == type && (there & 1u << sensor) != 0) {
            *handle = sensor;
            return true;
        }
    }
    return false;
}

bool chreGetSensorInfo(uint32_t handle, struct chreSensorInfo *info)
{
    memset(info, 0, sizeof *info);
    info->sensorName = "";
    info->sensorType = TYPES[handle];
    info->minInterval = (there & 0x10) != 0 ? 1000000 : (there & 0x20) != 0 ? CHRE_SENSOR_INTERVAL_DEFAULT : 20000000;
    return (there & 0x40) == 0;
}

bool chreSensorConfigure(uint32_t handle, enum chreSensorConfigureMode mode, uint64_t interval, uint64_t latency)
{
    (void)mode, (void)interval, (void)latency;
    require(handle < SENSORS, "only sensors that are there are set up");
    return (there & 0x80) == 0;
}

static void check_message(const uint8_t *bytes, size_t length, uint32_t type)
{
    require(length > 0 && length <= CHRE_MESSAGE_TO_HOST_MAX_SIZE, "a message has a length that the host takes");
    n_bias += type == FOS_MESSAGE_BIAS;
    n_frames += type == FOS_MESSAGE_FRAMES;
    if (type == FOS_MESSAGE_BIAS) {
        require(length == FOS_MESSAGE_BIAS_BYTES, "a bias has its length");
        for (int axis = 0; axis < FOS_AXES; axis++)
            require(isfinite(fos_message_get_float(bytes + 8 + 4 * axis)), "a bias is finite");
        require(bytes[46] <= 1 && bytes[47] <= 1, "still and drift are 0 or 1");
    } else if (type == FOS_MESSAGE_ANSWER) {
        require(length == FOS_MESSAGE_ANSWER_BYTES, "an answer has its length");
    } else {
        require(type == FOS_MESSAGE_FRAMES, "a message is of a known type");
        require(bytes[length - 1] == 0, "frames are whole");
    }
}

bool chreSendMessageToHostEndpoint(void *message, size_t length, uint32_t type, uint16_t endpoint,
                                   chreMessageFreeFunction *free_message)
{
    (void)endpoint;
    check_message(message, length, type);
    if (takes_nothing || n_pending == PENDING) {
        free_message(message, length);
        return false;
    }
    pending[n_pending].bytes = message;
    pending[n_pending].length = length;
    pending[n_pending].sum = sum_of(message, length);
    pending[n_pending++].give_back = free_message;
    return true;
}

/* An event of exactly the bytes that it has, so that one more is seen. */
static void hand_over(uint16_t type, const void *bytes, size_t length)
{
    void *event = malloc(length > 0 ? length : 1);
    memcpy(event, bytes, length);
    nanoappHandleEvent(0, type, event);
    free(event);
    if (!gives_nothing_back)
        give_back();
}

static uint64_t now[SENSORS];

static uint64_t interval_of(int sensor)
{
    return sensor == 0 ? UINT64_C(4807692) : sensor == 1 ? UINT64_C(9615385) : UINT64_C(1000000000);
}

static float value_of(int sensor, uint8_t how)
{
    if (how == 255) {
        uint32_t bits = (uint32_t)raw(4);
        float value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    float noise = ((float)how - 127.0f) * 1e-4f;
    return sensor == 0 ? noise : sensor == 1 ? 3.0f + 10.0f * noise : 25.0f + 100.0f * noise;
}

/* `wild`: stamps and values as the input says, else as a sensor would. */
static void readings(int sensor, int n, bool wild)
{
    static union {
        struct chreSensorThreeAxisData three;
        struct chreSensorFloatData one;
        uint8_t bytes[sizeof(struct chreSensorThreeAxisData) * (MOST_READINGS + 1)];
    } event;
    memset(&event, 0, sizeof event);
    bool three = sensor < 2;
    uint8_t how = byte();
    if (wild && (how & 1) != 0)
        now[sensor] = raw(8);
    event.three.header.baseTimestamp = now[sensor];
    event.three.header.sensorHandle = wild && (how & 2) != 0 ? byte() : (uint32_t)sensor;
    event.three.header.readingCount = (uint16_t)n;
    for (int k = 0; k < n; k++) {
        uint32_t delta = k == 0 ? 0 : wild && (how & 4) != 0 ? (uint32_t)raw(4) : (uint32_t)interval_of(sensor);
        now[sensor] += delta;
        if (three)
            event.three.readings[k].timestampDelta = delta;
        else
            event.one.readings[k].timestampDelta = delta;
        for (int axis = 0; axis < (three ? 3 : 1); axis++) {
            float value = value_of(sensor, wild ? byte() : (uint8_t)(how * (k + 7) + axis));
            if (three)
                event.three.readings[k].values[axis] = value;
            else
                event.one.readings[k].value = value;
        }
    }
    now[sensor] += interval_of(sensor);
    size_t reading = three ? sizeof event.three.readings : sizeof event.one.readings;
    hand_over((uint16_t)(CHRE_EVENT_SENSOR_DATA_EVENT_BASE + TYPES[sensor]), event.bytes,
              sizeof event.three.header + (size_t)n * reading);
}

/* As it should be, for so many batches. */
static void regular(int batches)
{
    for (int batch = 0; batch < batches; batch++) {
        readings(0, 42, false);
        readings(1, 21, false);
        if (batch % 5 == 0) {
            readings(2, 1, false);
            readings(3, 1, false);
        }
    }
}

static void message(uint32_t type, const uint8_t *bytes, size_t length)
{
    /* CHRE gives a copy of its own; NULL where there are no bytes */
    uint8_t *copy = length > 0 ? malloc(length) : NULL;
    if (length > 0)
        memcpy(copy, bytes, length);
    struct chreMessageFromHostData data = {0};
    data.messageType = type;
    data.messageSize = (uint32_t)length;
    data.message = copy;
    data.hostEndpoint = 7;
    hand_over(CHRE_EVENT_MESSAGE_FROM_HOST, &data, sizeof data);
    free(copy);
}

/* CRC-32 of Ethernet and zip, bit by bit. */
static uint32_t crc32(uint32_t crc, const uint8_t *bytes, size_t length)
{
    crc = ~crc;
    while (length-- > 0) {
        crc ^= *bytes++;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? UINT32_C(0xedb88320) : 0);
    }
    return ~crc;
}

/* The image of model.h as of values that the factory corrected: those of a phone. */
static void sound_image(uint8_t bytes[sizeof model])
{
    enum { FITTED_ON = 28, FACTORY_CORRECTED = 1 }; /* docs/MODEL_FORMAT.md */
    memcpy(bytes, model, sizeof model);
    bytes[FITTED_ON] = FACTORY_CORRECTED;
    fos_message_put(bytes + 16, crc32(crc32(0, bytes, 16), bytes + 20, sizeof model - 20), 4);
}

/* The sound image, in parts; damaged in so many places, the checksum made right again or not. */
static void image(int damages, bool repaired)
{
    static uint8_t bytes[sizeof model], part[8 + MOST_BYTES];
    sound_image(bytes);
    for (; damages > 0; damages--) {
        size_t place = raw(2) % sizeof model;
        bytes[place] = byte();
    }
    if (repaired) {
        uint32_t crc = crc32(crc32(0, bytes, 16), bytes + 20, sizeof model - 20);
        fos_message_put(bytes + 16, crc, 4);
    }
    size_t step = 1 + raw(2) % MOST_BYTES;
    for (size_t at = 0; at < sizeof model; at += step) {
        size_t n = sizeof model - at < step ? sizeof model - at : step;
        fos_message_put(fos_message_put(part, sizeof model, 4), at, 4);
        memcpy(part + 8, bytes + at, n);
        message(FOS_MESSAGE_MODEL, part, 8 + n);
    }
}

/* Parts of an image of any length, the last longer than it should be or not. */
static void any_parts(void)
{
    static uint8_t part[8 + MOST_BYTES];
    size_t whole = raw(2) % 5000, step = 1 + raw(2) % MOST_BYTES;
    bool overshoots = (byte() & 1) != 0;
    for (size_t at = 0; at < whole; at += step) {
        fos_message_put(fos_message_put(part, whole, 4), at, 4);
        memset(part + 8, byte(), step);
        message(FOS_MESSAGE_MODEL, part, 8 + (overshoots || whole - at > step ? step : whole - at));
    }
}

static void sampling_change(void)
{
    const uint64_t nominal[] = {4807692, 2403846, 9615385, 5000000, 1, 0, UINT32_MAX, UINT64_MAX};
    struct chreSensorSamplingStatusEvent event = {0};
    event.sensorHandle = byte() % (SENSORS + 1);
    uint8_t how = byte();
    event.status.interval = how < 8 ? nominal[how] : raw(1 + how % 8);
    event.status.latency = raw(2);
    event.status.enabled = (how & 0x80) == 0;
    hand_over(CHRE_EVENT_SENSOR_SAMPLING_CHANGE, &event, sizeof event);
}

static void any_message(void)
{
    static uint8_t bytes[MOST_BYTES];
    uint8_t how = byte();
    uint32_t type = how < 64 ? FOS_MESSAGE_MODEL + how % 5 : (uint32_t)raw(4);
    size_t length = how % 4 == 0 ? 1 : raw(2) % MOST_BYTES;
    for (size_t k = 0; k < length; k++)
        bytes[k] = byte();
    message(type, bytes, length);
}

static bool start(void)
{
    there = byte() ^ 0x0f; /* all of them, if the input does not say otherwise */
    return nanoappStart();
}

static void telemetry_on(void)
{
    const uint8_t on = 1;
    message(FOS_MESSAGE_TELEMETRY, &on, 1);
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Where all is as it should be, bias and telemetry come: else nothing was tested. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    require(start(), "the nanoapp starts");
    image(0, false);
    telemetry_on();
    regular(100);
    require(n_bias >= 15 && n_frames >= 100, "a model that is sound makes biases and telemetry");
    nanoappEnd();
    give_back();
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input = data;
    left = size;
    takes_nothing = gives_nothing_back = false;
    for (int sensor = 0; sensor < SENSORS; sensor++)
        now[sensor] = 1000000000;
    require(start(), "the nanoapp starts");
    while (left > 0) {
        uint8_t op = byte();
        switch (op % 16) {
        case 0: case 1: case 2: case 3:
            readings(op % 16, (int)raw(1) % MOST_READINGS, true);
            break;
        case 4: case 5:
            regular(1 + op / 16);
            break;
        case 6:
            sampling_change();
            break;
        case 7:
            any_message();
            break;
        case 8:
            image(0, false);
            break;
        case 9:
            if (op < 128)
                image(1 + op / 64, false);
            else
                any_parts();
            break;
        case 10:
            image(1 + op / 16, true);
            break;
        case 11:
            takes_nothing = (op & 16) != 0;
            gives_nothing_back = (op & 32) != 0;
            break;
        case 12:
            give_back();
            break;
        case 13:
            telemetry_on();
            break;
        case 14: {
            uint8_t motion = op / 16 % 4;
            message(FOS_MESSAGE_MOTION, &motion, 1);
            break;
        }
        default:
            if (op < 64) { /* ended, what is under way given back, started */
                nanoappEnd();
                give_back();
                require(start(), "the nanoapp starts again");
            } else {
                nanoappHandleEvent(0, (uint16_t)raw(2) | 0x8000, NULL); /* of another nanoapp */
            }
        }
    }
    nanoappEnd();
    give_back();
    return 0;
}
