/*
 * What the nanoapp costs on an emulated Cortex-M4F: stack, and instructions a sample of the gyro at 208 Hz, in batches of
 * 0.2 s. model.h has the image of a model as an array.
 *
 * Instructions are counted by SysTick: with `-icount shift=5` the emulator takes 32 ns an instruction, and the timer of
 * the board runs at 25 MHz.
 */
#include <chre.h>
#include <stdio.h>
#include <stdlib.h>

#include "fos.h"
#include "fos_nanoapp_messages.h"
#include "model.h"
#include "stack.h"

enum { GYRO, ACCEL, GYRO_TEMPERATURE, SENSORS };
enum { READINGS = 42, BATCHES = 300, SECOND = 5 };

static const uint8_t TYPES[SENSORS] = {
    CHRE_SENSOR_TYPE_UNCALIBRATED_GYROSCOPE,
    CHRE_SENSOR_TYPE_UNCALIBRATED_ACCELEROMETER,
    CHRE_SENSOR_TYPE_GYROSCOPE_TEMPERATURE,
};
static const uint32_t INTERVALS[SENSORS] = {4807692, 9615385, 1000000000};

#define SYSTICK ((volatile uint32_t *)0xe000e010) /* control, reload, current */

static unsigned long messages, wakeups, message_bytes;

bool chreSensorFindDefault(uint8_t type, uint32_t *handle)
{
    for (*handle = 0; *handle < SENSORS; ++*handle) {
        if (TYPES[*handle] == type)
            return true;
    }
    return false;
}

bool chreGetSensorInfo(uint32_t handle, struct chreSensorInfo *info)
{
    memset(info, 0, sizeof *info);
    info->minInterval = INTERVALS[handle];
    return true;
}

bool chreSensorConfigure(uint32_t handle, enum chreSensorConfigureMode mode, uint64_t interval, uint64_t latency)
{
    (void)handle, (void)mode, (void)interval, (void)latency;
    return true;
}

bool chreSendMessageToHostEndpoint(void *message, size_t length, uint32_t type, uint16_t endpoint,
                                   chreMessageFreeFunction *free_message)
{
    (void)type, (void)endpoint;
    messages++;
    message_bytes += length;
    free_message(message, length);
    return true;
}

static union {
    struct chreSensorThreeAxisData three;
    struct chreSensorFloatData one;
    uint8_t bytes[sizeof(struct chreSensorThreeAxisData) * (READINGS + 1)];
} event;

/* Noise that is always the same: the upper bits of a linear congruential generator (Knuth's MMIX), -1 to 1. */
static float noise(void)
{
    static uint64_t state = 1;
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(int32_t)(state >> 32) / 2147483648.0f;
}

static void fill(int sensor, int n)
{
    static uint64_t now[SENSORS] = {1000000000, 1001100000, 1000000000};
    memset(&event, 0, sizeof event);
    event.three.header.baseTimestamp = now[sensor];
    event.three.header.sensorHandle = (uint32_t)sensor;
    event.three.header.readingCount = (uint16_t)n;
    now[sensor] += (uint64_t)n * INTERVALS[sensor];
    for (int k = 0; k < n; k++) {
        uint32_t delta = k == 0 ? 0 : INTERVALS[sensor];
        if (sensor == GYRO_TEMPERATURE) {
            event.one.readings[k].timestampDelta = delta;
            event.one.readings[k].value = 25.0f + noise();
            continue;
        }
        event.three.readings[k].timestampDelta = delta;
        for (int axis = 0; axis < 3; axis++) {
            float rest = sensor == ACCEL && axis == 2 ? 9.81f : 0.0f;
            event.three.readings[k].values[axis] = rest + (sensor == GYRO ? 1e-3f : 1e-2f) * noise();
        }
    }
}

static void hand_over(int sensor)
{
    wakeups++;
    nanoappHandleEvent(0, (uint16_t)(CHRE_EVENT_SENSOR_DATA_EVENT_BASE + TYPES[sensor]), &event);
}

/* Of the SysTick's 40 ns, 32 of which are one instruction; most of 2^24 in one event there are not. */
static double instructions_of(int sensor)
{
    SYSTICK[2] = 0;
    uint32_t before = SYSTICK[2];
    hand_over(sensor);
    uint32_t ticks = (before - SYSTICK[2]) & 0xffffff;
    return ticks * 40.0 / 32.0;
}

static void message(uint32_t type, const void *bytes, size_t length)
{
    struct chreMessageFromHostData data = {0};
    data.messageType = type;
    data.messageSize = (uint32_t)length;
    data.message = bytes;
    nanoappHandleEvent(0, CHRE_EVENT_MESSAGE_FROM_HOST, &data);
}

static void run(const char *what)
{
    double sum = 0.0, worst = 0.0;
    unsigned long samples = 0;
    messages = message_bytes = wakeups = 0;
    for (int batch = 0; batch < BATCHES; batch++) {
        double in_batch = 0.0;
        if (batch % SECOND == 0) {
            fill(GYRO_TEMPERATURE, 1);
            in_batch += instructions_of(GYRO_TEMPERATURE);
        }
        fill(ACCEL, READINGS / 2);
        in_batch += instructions_of(ACCEL);
        fill(GYRO, READINGS);
        in_batch += instructions_of(GYRO);
        samples += READINGS;
        sum += in_batch;
        worst = in_batch > worst ? in_batch : worst;
    }
    double seconds = (double)samples / 208.0;
    printf("%s: %.0f instructions a sample, %.2f million a second, a batch at most %.0f; %.1f events, %.1f messages and "
           "%.0f bytes of them a second\n",
           what, sum / (double)samples, sum / seconds * 1e-6, worst, (double)wakeups / seconds,
           (double)messages / seconds, (double)message_bytes / seconds);
}

static void load(void)
{
    static uint8_t part[8 + sizeof model];
    fos_message_put(fos_message_put(part, sizeof model, 4), 0, 4);
    memcpy(part + 8, model, sizeof model);
    message(FOS_MESSAGE_MODEL, part, sizeof part);
}
static void gyro(void) { hand_over(GYRO); }
static void telemetry(void)
{
    const uint8_t on = 1;
    message(FOS_MESSAGE_TELEMETRY, &on, 1);
    hand_over(GYRO);
}

__attribute__((noinline)) static void stack_of(const char *what, void (*call)(void))
{
    uintptr_t painted = stack_paint();
    call();
    printf("stack, %s: %u bytes\n", what, (unsigned)stack_used(painted));
}

int main(void)
{
    SYSTICK[1] = 0xffffff;
    SYSTICK[0] = 5; /* on, at the clock of the core */
    if (!nanoappStart())
        return 1;
    stack_of("a model is sent", load);
    const uint8_t moving = FOS_MOTION_MOVING, detect = FOS_MOTION_DETECT;
    run("at rest");
    message(FOS_MESSAGE_MOTION, &moving, 1);
    run("in motion");
    message(FOS_MESSAGE_MOTION, &detect, 1);
    fill(ACCEL, READINGS / 2);
    hand_over(ACCEL);
    fill(GYRO, READINGS);
    stack_of("a batch", gyro);
    fill(ACCEL, READINGS / 2);
    hand_over(ACCEL);
    fill(GYRO, READINGS);
    stack_of("a batch with telemetry", telemetry);
    run("with telemetry");
    return messages > 0 ? 0 : 1;
}
