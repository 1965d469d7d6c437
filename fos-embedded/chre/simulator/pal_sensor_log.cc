// The sensors of CHRE's platform layer, played from a log: `chre/pal/sensor.h`.
//
// Every sensor delivers each k-th row of the log, by its own clock: stamps of its own, that jitter by a fixed sequence.
// Readings come in batches, as long as CHRE asks for. Time is that of the log: a batch is delivered when those before
// have been released, so that an hour lasts as long as the nanoapp takes for it, and the same log gives the same events.

#include "player.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>
#include <thread>

#include "chre/pal/sensor.h"
#include "chre/pal/version.h"

namespace fos {

namespace {

enum Which { GYRO, ACCEL, GYRO_TEMPERATURE, ACCEL_TEMPERATURE, SENSORS };

struct Kind {
    const char *name;
    uint8_t type;
    double slower; // than the gyro, at its fastest; 0: once a second
    int64_t late_ns; // its clock is behind that of the gyro
};

const Kind KINDS[SENSORS] = {
    {"gyro", CHRE_SENSOR_TYPE_UNCALIBRATED_GYROSCOPE, 1, 0},
    {"accel", CHRE_SENSOR_TYPE_UNCALIBRATED_ACCELEROMETER, 2, 1100000},
    {"gyro_temperature", CHRE_SENSOR_TYPE_GYROSCOPE_TEMPERATURE, 0, 300000},
    {"accel_temperature", CHRE_SENSOR_TYPE_ACCELEROMETER_TEMPERATURE, 0, 700000},
};

const int64_t JITTER_PERCENT = 5;         // of the gyro's period, at most, either way
const int64_t START_NS = 1000000000;      // stamp of the first row: a phone has been on for a second
const uint64_t BATCH_NS = 200000000;      // where CHRE does not say
const size_t MOST_READINGS = 10000;       // of one event
const size_t DISORDERED = 3;              // batches, the last first

// A sensor as CHRE has set it up, and the batch that it gathers.
struct Sensor {
    Which which;
    bool enabled;
    uint64_t every;    // of the log's rows
    uint64_t latency_ns;
    int64_t lost_until_ns;
    int64_t last_stamp;
    bool flush; // asked for, and not done
    std::vector<int64_t> stamps;
    std::vector<float> values; // three, or one, of each stamp
};

std::mutex guard; // of everything below but what only the player's thread touches
std::condition_variable released;
const chrePalSensorCallbacks *callbacks;
const Log *played;
std::vector<Step> script;
void (*others_step)(const Step &step);
chreSensorInfo infos[SENSORS];
Sensor sensors[SENSORS];
uint32_t n_sensors;
size_t outstanding;

// of the player's thread
std::thread thread;
enum Order { PROPER, SWAPPED, REVERSED } order;
bool flood, spoil, empty;
std::vector<std::pair<uint32_t, void *>> held_back;

// A number from 0 to 2^32 - 1 that depends on the two, and looks like chance (the finaliser of splitmix64).
uint32_t mixed(uint64_t a, uint64_t b)
{
    uint64_t x = a * UINT64_C(0x9e3779b97f4a7c15) + b;
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return static_cast<uint32_t>((x ^ x >> 31) >> 32);
}

bool is_three_axes(Which which) { return which == GYRO || which == ACCEL; }

uint64_t fastest(Which which)
{
    const Kind &kind = KINDS[which];
    uint64_t second = (1000000000 + played->period_ns / 2) / played->period_ns;
    return kind.slower > 0 ? static_cast<uint64_t>(kind.slower) : second;
}

uint64_t interval_ns(const Sensor &sensor) { return sensor.every * played->period_ns; }

void tell_status(uint32_t index)
{
    auto *status = new chreSensorSamplingStatus();
    {
        std::lock_guard<std::mutex> lock(guard);
        status->interval = interval_ns(sensors[index]);
        status->latency = sensors[index].latency_ns;
        status->enabled = sensors[index].enabled;
    }
    callbacks->samplingStatusUpdateCallback(index, status);
}

void *event_of(uint32_t index, const Sensor &sensor)
{
    size_t n = sensor.stamps.size();
    bool three = is_three_axes(sensor.which);
    size_t reading = three ? sizeof(chreSensorThreeAxisData::readings) : sizeof(chreSensorFloatData::readings);
    void *event = std::calloc(1, sizeof(chreSensorDataHeader) + std::max<size_t>(n, 1) * reading);
    auto *header = static_cast<chreSensorDataHeader *>(event);
    header->baseTimestamp = static_cast<uint64_t>(n > 0 ? sensor.stamps[0] : START_NS);
    header->sensorHandle = index;
    header->readingCount = static_cast<uint16_t>(n);
    header->accuracy = CHRE_SENSOR_ACCURACY_MEDIUM;
    for (size_t k = 0; k < n; k++) {
        auto delta = static_cast<uint32_t>(k > 0 ? sensor.stamps[k] - sensor.stamps[k - 1] : 0);
        if (three) {
            auto &to = static_cast<chreSensorThreeAxisData *>(event)->readings[k];
            to.timestampDelta = delta;
            std::memcpy(to.values, &sensor.values[3 * k], sizeof to.values);
        } else {
            auto &to = static_cast<chreSensorFloatData *>(event)->readings[k];
            to.timestampDelta = delta;
            to.value = sensor.values[k];
        }
    }
    return event;
}

void wait_until_taken()
{
    std::unique_lock<std::mutex> lock(guard);
    released.wait(lock, [] { return outstanding == 0; });
}

void deliver(uint32_t index, void *event)
{
    {
        std::lock_guard<std::mutex> lock(guard);
        outstanding++;
    }
    callbacks->dataEventCallback(index, event);
    if (!flood)
        wait_until_taken();
}

// In the order of the script: the last first, or as they came.
void deliver_held_back()
{
    if (order != PROPER)
        std::reverse(held_back.begin(), held_back.end());
    for (const auto &held : held_back)
        deliver(held.first, held.second);
    held_back.clear();
}


void end_batch(uint32_t index)
{
    Sensor taken;
    {
        std::lock_guard<std::mutex> lock(guard);
        taken = sensors[index];
        sensors[index].stamps.clear();
        sensors[index].values.clear();
    }
    if (taken.stamps.empty())
        return;
    if (order == SWAPPED && !is_three_axes(taken.which)) {
        deliver(index, event_of(index, taken)); // as soon as it is there: rows do not wait for it
        return;
    }
    if (order == SWAPPED && !held_back.empty() && held_back[0].first == index)
        deliver_held_back(); // not a pair
    held_back.emplace_back(index, event_of(index, taken));
    if (order == PROPER || held_back.size() >= (order == SWAPPED ? 2 : DISORDERED))
        deliver_held_back();
    if (empty) {
        taken.stamps.clear();
        deliver(index, event_of(index, taken));
    }
}

// What is gathered, and that it was all.
void flush_if_asked(uint32_t index)
{
    {
        std::lock_guard<std::mutex> lock(guard);
        if (!sensors[index].flush)
            return;
        sensors[index].flush = false;
    }
    end_batch(index);
    deliver_held_back();
    callbacks->flushCompleteCallback(index, CHRE_PAL_SENSOR_FLUSH_UNSUPPORTED_REQUEST_ID, CHRE_ERROR_NONE);
}

void read(uint32_t index, size_t row_number, const Row &row)
{
    bool full;
    {
        std::lock_guard<std::mutex> lock(guard);
        Sensor &sensor = sensors[index];
        int64_t after_ns = row.stamp_ns - played->rows[0].stamp_ns;
        if (!sensor.enabled || row_number % sensor.every != 0 || after_ns < sensor.lost_until_ns)
            return;
        auto period = static_cast<int64_t>(played->period_ns);
        int64_t jitter = period * JITTER_PERCENT / 100;
        jitter = static_cast<int64_t>(mixed(sensor.which, row_number) % static_cast<uint64_t>(2 * jitter + 1)) - jitter;
        // of a log whose own stamps jitter, too
        int64_t stamp = std::max(START_NS + after_ns + KINDS[sensor.which].late_ns + jitter, sensor.last_stamp + 1);
        sensor.last_stamp = stamp;
        const float *values = sensor.which == GYRO ? row.gyro : sensor.which == ACCEL ? row.accel : &row.temperature_c;
        for (int axis = 0; axis < (is_three_axes(sensor.which) ? 3 : 1); axis++) {
            const float wild[] = {NAN, INFINITY, -INFINITY, 1e38f, -1e38f};
            uint32_t chance = mixed(sensor.which + 100 + static_cast<uint64_t>(axis), row_number);
            sensor.values.push_back(spoil && chance % 20 == 0 ? wild[chance / 20 % 5] : values[axis]);
        }
        sensor.stamps.push_back(stamp);
        auto lasts = static_cast<uint64_t>(stamp - sensor.stamps[0]) + interval_ns(sensor);
        full = lasts > sensor.latency_ns + interval_ns(sensor) / 2 || sensor.stamps.size() >= MOST_READINGS;
    }
    if (full)
        end_batch(index);
}

// The sensor of this name; SENSORS where there is none.
uint32_t named(const std::string &name)
{
    for (uint32_t index = 0; index < n_sensors; index++) {
        if (name == infos[index].sensorName)
            return index;
    }
    return SENSORS;
}

void take(const Step &step)
{
    bool on = !step.words.empty() && step.words[0] == "on";
    if (step.what == "flood") {
        flood = on;
    } else if (step.what == "spoil") {
        spoil = on;
    } else if (step.what == "empty") {
        empty = on;
    } else if (step.what == "order") {
        deliver_held_back();
        order = step.words[0] == "reversed" ? REVERSED : step.words[0] == "swapped" ? SWAPPED : PROPER;
    } else if (step.what == "rate" || step.what == "lose") {
        uint32_t index = named(step.words[0]);
        double number = std::strtod(step.words[1].c_str(), nullptr);
        if (index == SENSORS || !(number > 0))
            return;
        if (step.what == "lose") {
            std::lock_guard<std::mutex> lock(guard);
            sensors[index].lost_until_ns = step.after_ns + static_cast<int64_t>(number * 1e9);
            return;
        }
        end_batch(index);
        {
            std::lock_guard<std::mutex> lock(guard);
            sensors[index].every = static_cast<uint64_t>(number);
        }
        tell_status(index);
    } else if (step.what != "missing") {
        others_step(step);
    }
}

void play(void (*ended)())
{
    size_t at = 0;
    for (size_t number = 0; number < played->rows.size(); number++) {
        const Row &row = played->rows[number];
        for (; at < script.size() && script[at].after_ns <= row.stamp_ns - played->rows[0].stamp_ns; at++)
            take(script[at]);
        for (uint32_t index = 0; index < n_sensors; index++) {
            flush_if_asked(index);
            read(index, number, row);
        }
    }
    for (uint32_t index = 0; index < n_sensors; index++)
        end_batch(index);
    deliver_held_back();
    wait_until_taken();
    ended();
}

bool is_missing(Which which)
{
    return std::any_of(script.begin(), script.end(), [which](const Step &step) {
        return step.what == "missing" && step.words[0] == KINDS[which].name;
    });
}

// What CHRE calls.

bool open(const chrePalSystemApi *, const chrePalSensorCallbacks *given)
{
    callbacks = given;
    return true;
}

void close() {}

bool get_sensors(chreSensorInfo *const *array, uint32_t *count)
{
    n_sensors = 0;
    for (int which = 0; which < SENSORS; which++) {
        if (is_missing(static_cast<Which>(which)))
            continue;
        chreSensorInfo &info = infos[n_sensors];
        info = chreSensorInfo();
        info.sensorName = KINDS[which].name;
        info.sensorType = KINDS[which].type;
        info.supportsPassiveMode = 1;
        info.minInterval = fastest(static_cast<Which>(which)) * played->period_ns;
        Sensor &sensor = sensors[n_sensors];
        sensor = Sensor();
        sensor.which = static_cast<Which>(which);
        sensor.every = fastest(sensor.which);
        n_sensors++;
    }
    // the declaration says an array that cannot be replaced, what it means is to give one out
    *const_cast<chreSensorInfo **>(array) = infos;
    *count = n_sensors;
    return true;
}

bool configure(uint32_t index, chreSensorConfigureMode mode, uint64_t interval, uint64_t latency)
{
    if (index >= n_sensors)
        return false;
    {
        std::lock_guard<std::mutex> lock(guard);
        Sensor &sensor = sensors[index];
        // nobody else has it powered: who is passive gets nothing
        sensor.enabled = (mode & CHRE_SENSOR_CONFIGURE_RAW_POWER_ON) != 0;
        sensor.every = fastest(sensor.which);
        // as slow as is asked for, and no slower
        if (interval != CHRE_SENSOR_INTERVAL_DEFAULT)
            sensor.every *= std::max<uint64_t>(1, interval / (sensor.every * played->period_ns));
        sensor.latency_ns = latency == CHRE_SENSOR_LATENCY_DEFAULT ? BATCH_NS : latency;
        if (!sensor.enabled) {
            sensor.stamps.clear();
            sensor.values.clear();
        }
    }
    tell_status(index);
    return true;
}

// Done by the player's thread, before its next row.
bool flush(uint32_t index, uint32_t *request)
{
    *request = CHRE_PAL_SENSOR_FLUSH_UNSUPPORTED_REQUEST_ID;
    std::lock_guard<std::mutex> lock(guard);
    sensors[index].flush = true;
    return true;
}

// Uncalibrated: there is no bias.
bool configure_bias(uint32_t, bool enable, uint64_t) { return !enable; }
bool get_bias(uint32_t, chreSensorThreeAxisData *) { return false; }

void release_data(void *data)
{
    std::free(data);
    std::lock_guard<std::mutex> lock(guard);
    outstanding--;
    released.notify_all();
}

void release_status(chreSensorSamplingStatus *status) { delete status; }

void release_bias(void *) {}

const chrePalSensorApi API = {
    CHRE_PAL_CREATE_MODULE_VERSION(CHRE_PAL_SENSOR_API_CURRENT_VERSION, 0),
    open,
    close,
    get_sensors,
    configure,
    flush,
    configure_bias,
    get_bias,
    release_data,
    release_status,
    release_bias,
};

} // namespace

void open_player(const Log &log, const std::vector<Step> &steps, void (*other)(const Step &step))
{
    played = &log;
    script = steps;
    others_step = other;
}

void start_player(void (*ended)()) { thread = std::thread(play, ended); }

void close_player()
{
    if (thread.joinable())
        thread.join();
}

} // namespace fos

const chrePalSensorApi *chrePalSensorGetApi(uint32_t requested)
{
    return CHRE_PAL_VERSIONS_ARE_COMPATIBLE(fos::API.moduleVersion, requested) ? &fos::API : nullptr;
}
