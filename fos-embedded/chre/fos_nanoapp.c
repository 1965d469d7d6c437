/*
 * A nanoapp for Android's sensor hub (CHRE): joins the streams of the uncalibrated sensors, runs the model over them, and
 * sends the bias to its host.
 *
 * Everything is done in nanoappHandleEvent(), at once: nothing is allocated, nothing waits, no timer is set. What cannot
 * be sent is lost and counted. What host and nanoapp say: fos_nanoapp_messages.h; how it is built in: docs/phone.md.
 */
#include <chre.h>

#include "fos.h"
#include "fos_nanoapp_host.h"
#include "fos_nanoapp_image.h"
#include "fos_nanoapp_messages.h"

/* What is asked for. The hub runs at the gyro's interval: that of the logs that models are fitted to, 208 Hz. */
#ifndef FOS_NANOAPP_GYRO_NS
#define FOS_NANOAPP_GYRO_NS UINT64_C(4807692)
#endif
#ifndef FOS_NANOAPP_ACCEL_NS
#define FOS_NANOAPP_ACCEL_NS UINT64_C(9615385)
#endif
#ifndef FOS_NANOAPP_TEMPERATURE_NS
#define FOS_NANOAPP_TEMPERATURE_NS UINT64_C(1000000000)
#endif

/* The hub is woken so often. */
#ifndef FOS_NANOAPP_BATCH_NS
#define FOS_NANOAPP_BATCH_NS UINT64_C(200000000)
#endif

/* Full scale of the sensor, m/s^2 and rad/s: 8 g and 2000 dps. */
#ifndef FOS_NANOAPP_ACCEL_FULL_SCALE
#define FOS_NANOAPP_ACCEL_FULL_SCALE 78.4532f
#endif
#ifndef FOS_NANOAPP_GYRO_FULL_SCALE
#define FOS_NANOAPP_GYRO_FULL_SCALE 34.906585f
#endif

/*
 * A message wakes the host, which costs more than the hub does in a second. So a bias goes out at most once a batch,
 * when what speaks against it has changed or it has moved by so much that a second of it would show: a milli-g, or 0.06
 * degrees of angle. Without a change it goes out once a second: a host that starts late has it soon, and knows that we run.
 */
#define BIAS_AT_LEAST_EVERY_NS UINT64_C(1000000000)
static const float ACCEL_STEP = 1e-2f, GYRO_STEP = 1e-3f; /* m/s^2, rad/s */

/* Half a batch: of gyro and accelerometer one may end it with a few samples, which go with the next. */
#define FEWEST_IN_MEAN (FOS_NANOAPP_BATCH_NS / FOS_NANOAPP_GYRO_NS / 2)

/* What the samples of telemetry hold is said again so often, for those who join late. */
#define START_FRAME_NS UINT64_C(60000000000)

/* Frames wait at most so long for their message to be full. */
#define FRAMES_WAIT_NS UINT64_C(1000000000)

/* The temperature of the gyro counts; after so long without it that of the accelerometer does. */
#define TEMPERATURE_WAIT_NS INT64_C(5000000000)

/* A sensor that others want faster gives at most so many readings for one of ours. */
enum { MOST_READINGS_A_SAMPLE = 64 };

/* Periods are the same if they differ by less than this part of one: what the clocks of sensors differ by. */
enum { SAME_PERIOD = 100 };

enum { GYRO, ACCEL, GYRO_TEMPERATURE, ACCEL_TEMPERATURE, SENSORS };

static const struct {
    uint8_t type;
    uint64_t interval_ns;
} WANTED[SENSORS] = {
    {CHRE_SENSOR_TYPE_UNCALIBRATED_GYROSCOPE, FOS_NANOAPP_GYRO_NS},
    {CHRE_SENSOR_TYPE_UNCALIBRATED_ACCELEROMETER, FOS_NANOAPP_ACCEL_NS},
    {CHRE_SENSOR_TYPE_GYROSCOPE_TEMPERATURE, FOS_NANOAPP_TEMPERATURE_NS},
    {CHRE_SENSOR_TYPE_ACCELEROMETER_TEMPERATURE, FOS_NANOAPP_TEMPERATURE_NS},
};

static uint64_t hub_memory[FOS_HUB_BYTES / 8];
static uint64_t streams_memory[(FOS_STREAMS_BYTES + 7) / 8];
static uint8_t image[FOS_NANOAPP_IMAGE_BYTES]; /* of the model that runs; the frames that start telemetry need it */

/* All else; it starts as zeros. */
static struct {
    fos_hub *hub;
    fos_streams *streams;
    fos_stream_periods periods; /* of the gyro: the hub's */
    fos_report report;
    uint32_t handles[SENSORS];

    uint32_t readings_a_sample;
    uint32_t gathered; /* readings of the next sample, their sum, the first and the last stamp */
    float sum[3];
    uint64_t first_stamp, last_stamp;
    uint64_t gyro_temperature_stamp;

    bool has_model; /* and the hub has loaded it */
    fos_motion motion;

    fos_si_output output; /* of the latest sample */
    int64_t stamp;
    uint32_t in_batch; /* samples since the batch before, and the mean of what was predicted for them */
    float mean[FOS_AXES];
    uint16_t faults; /* since the last bias */

    fos_si_output sent; /* the last bias */
    int64_t sent_stamp;
    bool has_sent;

    bool telemetry;
    uint16_t telemetry_endpoint;
    bool start_frame_sent;
    int64_t start_frame_stamp, frames_stamp;
} app;

/* From one stamp to another; wraps, so that one of before is far away. */
static uint64_t between(int64_t from, int64_t to) { return (uint64_t)to - (uint64_t)from; }

static bool has(int sensor) { return (app.report.sensors & 1u << sensor) != 0; }

static void answer(uint32_t command, fos_status status, uint16_t endpoint)
{
    fos_host_answer(command, status, &app.report, endpoint);
}

static fos_status scales_of(uint64_t period_ns, fos_scales *scales)
{
    return fos_scales_of_full_scale(FOS_NANOAPP_ACCEL_FULL_SCALE, FOS_NANOAPP_GYRO_FULL_SCALE, (double)period_ns * 1e-9,
                                    FOS_VALUES_FACTORY_CORRECTED, scales);
}

static fos_status load(void)
{
    fos_status status = fos_hub_load(app.hub, image, app.report.image_bytes);
    app.has_model = status == FOS_STATUS_OK;
    app.start_frame_sent = false;
    return status;
}

/* A hub for this period, and the model if there is one. */
static fos_status start_hub(uint64_t period_ns)
{
    fos_scales scales;
    fos_status status = scales_of(period_ns, &scales);
    if (status == FOS_STATUS_OK)
        status = fos_hub_init(hub_memory, sizeof hub_memory, &scales, &app.hub);
    if (status == FOS_STATUS_OK)
        status = fos_hub_set_motion(app.hub, app.motion);
    app.has_model = false;
    app.start_frame_sent = false;
    return status == FOS_STATUS_OK && app.report.image_bytes > 0 ? load() : status;
}

/* Telemetry of the sample that the hub has just taken. */
static void send_telemetry(void)
{
    bool begin = !app.start_frame_sent || between(app.start_frame_stamp, app.stamp) >= START_FRAME_NS;
    const uint8_t *names = app.has_model ? image : NULL;
    size_t length = app.has_model ? app.report.image_bytes : 0;
    if (fos_host_frames(app.hub, names, length, begin, app.telemetry_endpoint) && begin) {
        app.start_frame_sent = true;
        app.start_frame_stamp = app.stamp;
    }
    if (between(app.frames_stamp, app.stamp) >= FRAMES_WAIT_NS) {
        fos_host_send_frames(app.telemetry_endpoint);
        app.frames_stamp = app.stamp;
    }
}

/* Every sample that is joined goes through the hub. */
static void drain(void)
{
    fos_si_sample sample;
    while (fos_streams_next(app.streams, &sample, &app.stamp) == FOS_STATUS_OK) {
        if (fos_hub_update_si(app.hub, &sample, &app.output) != FOS_STATUS_OK)
            return;
        app.report.rows++;
        app.faults |= app.output.output.faults;
        app.in_batch++;
        for (int axis = 0; axis < FOS_AXES; axis++)
            app.mean[axis] += (app.output.predicted[axis] - app.mean[axis]) / (float)app.in_batch;
        if (app.telemetry)
            send_telemetry();
    }
}

static bool has_moved(float from, float to, float step) { return !(to - from <= step && from - to <= step); }

static bool has_changed(const fos_si_output *bias)
{
    const fos_output *now = &bias->output, *before = &app.sent.output;
    bool changed = now->faults != before->faults || now->still != before->still || now->drift != before->drift;
    for (int axis = 0; axis < FOS_AXES; axis++) {
        float step = axis < FOS_GX ? ACCEL_STEP : GYRO_STEP;
        changed = changed || now->validity[axis] != before->validity[axis] ||
                  has_moved(app.sent.predicted[axis], bias->predicted[axis], step);
    }
    return changed;
}

/*
 * After a batch: the clock of the hub, and the bias if it is due. The bias is the mean of what was predicted in the batch:
 * it holds for the next fifth of a second, and what a model predicts of the noise from one sample to the next does not.
 * Without a model there is no bias; with one that does not fit the rate there is: that nothing is modelled must be known.
 */
static void end_batch(void)
{
    if (app.in_batch < FEWEST_IN_MEAN)
        return;
    fos_si_output bias = app.output;
    bias.output.faults = app.faults;
    for (int axis = 0; axis < FOS_AXES; axis++) {
        bias.predicted[axis] = app.mean[axis];
        app.mean[axis] = 0.0f;
    }
    app.in_batch = 0;
    (void)fos_hub_clock(app.hub, (uint64_t)app.stamp / 1000);
    uint64_t age = between(app.sent_stamp, app.stamp);
    bool due = !app.has_sent || age >= BIAS_AT_LEAST_EVERY_NS || (age >= FOS_NANOAPP_BATCH_NS && has_changed(&bias));
    if (app.report.image_bytes == 0 || !due)
        return;
    if (fos_host_bias(app.stamp, &bias)) {
        app.sent = bias;
        app.sent_stamp = app.stamp;
        app.has_sent = true;
        app.faults = 0;
    }
}

static void count(fos_status status)
{
    if (status != FOS_STATUS_OK)
        app.report.readings_refused++;
}

/* Readings that come faster than samples are needed are averaged: what is left out would fold into the noise. */
static void take_gyro(uint64_t stamp, const float value[3])
{
    if (app.readings_a_sample == 1) {
        count(fos_streams_gyro(app.streams, (int64_t)stamp, value));
        drain();
        return;
    }
    /* across a gap there is no average */
    if (stamp - app.last_stamp > 2 * (uint64_t)app.report.gyro_interval_ns)
        app.gathered = 0;
    app.last_stamp = stamp;
    if (app.gathered == 0) {
        app.first_stamp = stamp;
        for (int axis = 0; axis < 3; axis++)
            app.sum[axis] = 0.0f;
    }
    for (int axis = 0; axis < 3; axis++)
        app.sum[axis] += value[axis];
    if (++app.gathered < app.readings_a_sample)
        return;
    float mean[3];
    for (int axis = 0; axis < 3; axis++)
        mean[axis] = app.sum[axis] / (float)app.gathered;
    app.gathered = 0;
    count(fos_streams_gyro(app.streams, (int64_t)(app.first_stamp + (stamp - app.first_stamp) / 2), mean));
    drain();
}

static void take_three_axes(int sensor, const struct chreSensorThreeAxisData *data)
{
    if (!has(sensor) || data->header.sensorHandle != app.handles[sensor])
        return;
    uint64_t stamp = data->header.baseTimestamp;
    for (uint16_t k = 0; k < data->header.readingCount; k++) {
        stamp += data->readings[k].timestampDelta;
        if (sensor == GYRO)
            take_gyro(stamp, data->readings[k].values);
        else
            count(fos_streams_accel(app.streams, (int64_t)stamp, data->readings[k].values));
    }
    drain();
    end_batch();
}

static void take_temperatures(int sensor, const struct chreSensorFloatData *data)
{
    if (!has(sensor) || data->header.sensorHandle != app.handles[sensor])
        return;
    uint64_t stamp = data->header.baseTimestamp;
    for (uint16_t k = 0; k < data->header.readingCount; k++) {
        stamp += data->readings[k].timestampDelta;
        if (sensor == GYRO_TEMPERATURE)
            app.gyro_temperature_stamp = stamp;
        else if (has(GYRO_TEMPERATURE) && (int64_t)(stamp - app.gyro_temperature_stamp) < TEMPERATURE_WAIT_NS)
            continue; /* also where it is a little older */
        count(fos_streams_temperature(app.streams, (int64_t)stamp, data->readings[k].value));
    }
}

/*
 * The gyro belongs to everybody, and another may have it faster: then so many readings make one sample that the period is
 * the model's still. At another period the hub starts anew; a model that does not hold there is refused, and the host is
 * told.
 */
static void set_gyro_interval(uint64_t interval_ns)
{
    uint64_t readings = (FOS_NANOAPP_GYRO_NS + interval_ns / 2) / interval_ns;
    if (readings < 1)
        readings = 1;
    if (readings > MOST_READINGS_A_SAMPLE)
        readings = MOST_READINGS_A_SAMPLE;
    uint64_t period = readings * interval_ns, before = app.periods.gyro_ns;
    app.readings_a_sample = (uint32_t)readings;
    app.gathered = 0;
    app.report.gyro_interval_ns = (uint32_t)interval_ns;
    uint64_t off = period > before ? period - before : before - period;
    if (off <= before / SAME_PERIOD)
        return;
    app.periods.gyro_ns = period;
    answer(0, start_hub(period), CHRE_HOST_ENDPOINT_BROADCAST);
}

static void take_sampling(const struct chreSensorSamplingStatusEvent *event)
{
    uint64_t interval = event->status.interval;
    for (int sensor = 0; sensor < SENSORS; sensor++) {
        if (!has(sensor) || event->sensorHandle != app.handles[sensor])
            continue;
        if (!event->status.enabled && sensor == GYRO)
            app.report.gyro_interval_ns = 0;
        if (!event->status.enabled || interval == 0 || interval > UINT32_MAX)
            return; /* not meaningful, or not known */
        if (sensor == GYRO)
            set_gyro_interval(interval);
        else if (sensor == ACCEL)
            app.periods.accel_ns = interval;
        else
            app.periods.temperature_ns = interval;
        (void)fos_streams_set_periods(app.streams, &app.periods);
    }
}

/* A part of an image; the model that runs is given up when the next is whole and sound. True if it has an answer. */
static bool take_part(const uint8_t *bytes, size_t length, fos_status *status)
{
    fos_scales scales;
    *status = scales_of(FOS_NANOAPP_GYRO_NS, &scales);
    if (*status == FOS_STATUS_OK && !fos_image_take_part(bytes, length, &scales, status))
        return false;
    if (*status != FOS_STATUS_OK) {
        app.report.models_refused++;
        return true;
    }
    size_t image_bytes;
    const uint8_t *arrived = fos_image_arrived(&image_bytes);
    memcpy(image, arrived, image_bytes);
    app.report.image_bytes = (uint32_t)image_bytes;
    app.report.image_checksum = (uint32_t)fos_message_get(image + 16, 4);
    app.report.models_taken++;
    app.has_sent = false;
    *status = load();
    return true;
}

static fos_status set_telemetry(uint8_t on, uint16_t endpoint)
{
    if (on > 1)
        return FOS_STATUS_ARGUMENT;
    if (on == 0)
        fos_host_send_frames(app.telemetry_endpoint);
    app.telemetry = on == 1;
    app.telemetry_endpoint = endpoint;
    app.start_frame_sent = false;
    app.frames_stamp = app.stamp;
    return FOS_STATUS_OK;
}

static void take_message(const struct chreMessageFromHostData *data)
{
    const uint8_t *bytes = data->message;
    size_t length = bytes != NULL ? data->messageSize : 0;
    fos_status status = FOS_STATUS_ARGUMENT;
    switch (data->messageType) {
    case FOS_MESSAGE_MODEL:
        if (!take_part(bytes, length, &status))
            return;
        break;
    case FOS_MESSAGE_STATUS:
        status = FOS_STATUS_OK;
        break;
    case FOS_MESSAGE_TELEMETRY:
        if (length == 1)
            status = set_telemetry(bytes[0], data->hostEndpoint);
        break;
    case FOS_MESSAGE_MOTION:
        if (length == 1)
            status = fos_hub_set_motion(app.hub, bytes[0]);
        if (status == FOS_STATUS_OK)
            app.motion = bytes[0];
        break;
    default:
        break; /* of a host that is newer: it is told that this is not known */
    }
    answer(data->messageType, status, data->hostEndpoint);
}

/* The sensor of this place, as often as we want it, or as it can; it need not be there. */
static void subscribe(int sensor)
{
    struct chreSensorInfo info;
    uint32_t handle;
    if (!chreSensorFindDefault(WANTED[sensor].type, &handle) || !chreGetSensorInfo(handle, &info))
        return;
    uint64_t interval = WANTED[sensor].interval_ns;
    if (info.minInterval != CHRE_SENSOR_INTERVAL_DEFAULT && info.minInterval > interval)
        interval = info.minInterval;
    if (!chreSensorConfigureWithBatchInterval(handle, CHRE_SENSOR_CONFIGURE_MODE_CONTINUOUS, interval,
                                              FOS_NANOAPP_BATCH_NS))
        return;
    app.handles[sensor] = handle;
    app.report.sensors |= 1u << sensor;
}

bool nanoappStart(void)
{
    memset(&app, 0, sizeof app);
    fos_host_start();
    fos_image_start();
    app.readings_a_sample = 1;
    app.periods.gyro_ns = FOS_NANOAPP_GYRO_NS;
    app.periods.accel_ns = FOS_NANOAPP_ACCEL_NS;
    app.periods.temperature_ns = FOS_NANOAPP_TEMPERATURE_NS;
    if (start_hub(FOS_NANOAPP_GYRO_NS) != FOS_STATUS_OK ||
        fos_streams_init(streams_memory, sizeof streams_memory, &app.periods, &app.streams) != FOS_STATUS_OK)
        return false;
    for (int sensor = 0; sensor < SENSORS; sensor++)
        subscribe(sensor);
    answer(0, FOS_STATUS_OK, CHRE_HOST_ENDPOINT_BROADCAST);
    return true;
}

void nanoappHandleEvent(uint32_t sender, uint16_t type, const void *data)
{
    (void)sender;
    switch (type) {
    case CHRE_EVENT_SENSOR_UNCALIBRATED_GYROSCOPE_DATA:
        take_three_axes(GYRO, data);
        break;
    case CHRE_EVENT_SENSOR_UNCALIBRATED_ACCELEROMETER_DATA:
        take_three_axes(ACCEL, data);
        break;
    case CHRE_EVENT_SENSOR_GYROSCOPE_TEMPERATURE_DATA:
        take_temperatures(GYRO_TEMPERATURE, data);
        break;
    case CHRE_EVENT_SENSOR_ACCELEROMETER_TEMPERATURE_DATA:
        take_temperatures(ACCEL_TEMPERATURE, data);
        break;
    case CHRE_EVENT_SENSOR_SAMPLING_CHANGE:
        take_sampling(data);
        break;
    case CHRE_EVENT_MESSAGE_FROM_HOST:
        take_message(data);
        break;
    default:
        break;
    }
}

void nanoappEnd(void)
{
    for (int sensor = 0; sensor < SENSORS; sensor++) {
        if (has(sensor))
            (void)chreSensorConfigureModeOnly(app.handles[sensor], CHRE_SENSOR_CONFIGURE_MODE_DONE);
    }
}
