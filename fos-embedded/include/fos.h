/*
 * fos: takes the error out of the samples of a six-axis inertial sensor, by a model that was fitted before.
 *
 *     static uint64_t memory[FOS_HUB_BYTES / 8];
 *     fos_hub *hub;
 *     fos_status status = fos_hub_init(memory, sizeof memory, &scales, &hub);
 *     if (status == FOS_STATUS_OK)
 *         status = fos_hub_load(hub, image, image_length);
 *     if (status != FOS_STATUS_OK)
 *         return report(status); // or go on: with a model refused the hub corrects nothing, and every output says so
 *     for (;;) {
 *         read_sensor(&raw);
 *         (void)fos_hub_update(hub, &raw, &output); // refuses NULL and misaligned pointers only
 *         use(&output); // what speaks against it: output.validity, output.faults
 *     }
 *
 * What holds for every function:
 *
 * - Memory is the caller's. Nothing is allocated and nothing is kept of what is passed but the memory of the hub
 *   itself. A pointer leads to one object of its type, or to as many bytes as the length beside it says; these do not
 *   overlap the hub. A `fos_hub *` is one that fos_hub_init() gave out. That much cannot be checked here.
 * - Checked is: NULL, alignment, lengths that no memory can have, numbers that stand for nothing. What is refused has a
 *   status, and nothing was done but what the function says. No function panics or aborts, and none waits.
 * - Threads: a hub is in one call at a time; calls from an interrupt and a task need a lock of the caller's. Different
 *   hubs do not know of each other: there is no global state. Functions without a hub can be called at any time.
 * - Units are in the comment of every number: SI, but degrees Celsius. An interrupt that calls fos_hub_update() must
 *   save the registers of the floating-point unit, if there is one.
 *
 * Generated from fos-embedded/src/c_api; do not edit. FOS_WRITE_HEADER=1 cargo test -p fos-embedded --test c_header
 */

#ifndef FOS_H
#define FOS_H

#include <stddef.h>
#include <stdint.h>

// Version of this interface: raised when a program that was compiled with the header before would no longer run
// rightly. fos_api_version() is that of the library.
#define FOS_API_VERSION 1

// Axes of a sensor, at these places of every array of six: accelerometer x, y, z, then gyro x, y, z.
#define FOS_AXES 6

// Accelerometer x.
#define FOS_AX 0

// Accelerometer y.
#define FOS_AY 1

// Accelerometer z.
#define FOS_AZ 2

// Gyro x.
#define FOS_GX 3

// Gyro y.
#define FOS_GY 4

// Gyro z.
#define FOS_GZ 5

// A hub takes models of at most so many inputs, and as many logged quantities.
#define FOS_MAX_INPUTS 16

// A hub takes models of at most so many terms, all axes together.
#define FOS_MAX_TERMS 128

// A hub holds so many values of history: at least (longest lag) x (inputs + axes) + inputs of a model.
#define FOS_MAX_HISTORY 256

// Validity: nothing speaks against the value.
#define FOS_VALIDITY_VALID 0

// Validity: the history is not full yet; only the part of the error that inputs explain is taken out.
#define FOS_VALIDITY_WARMING_UP 1

// Validity: some of the history is the model's own prediction; normal in motion and for a few samples after it.
#define FOS_VALIDITY_OWN_HISTORY 2

// Validity: in motion for longer than the model was validated for; the predicted part fades out.
#define FOS_VALIDITY_COASTING_TOO_LONG 4

// Validity: the error is far outside what was seen while fitting; it was limited.
#define FOS_VALIDITY_OUTPUT_OUT_OF_RANGE 8

// Validity: an input, or the inputs together, are outside what was seen while fitting; the edge of that range was used.
#define FOS_VALIDITY_INPUT_OUT_OF_RANGE 16

// Validity: the measured value is not finite; the corrected value before is repeated.
#define FOS_VALIDITY_NOT_FINITE 32

// Validity: a logged quantity is not finite or was never given; its last finite value was used.
#define FOS_VALIDITY_INPUT_NOT_FINITE 64

// Validity: the measured value is at full scale.
#define FOS_VALIDITY_SATURATED 128

// Validity: the measured value has repeated for longer than noise allows.
#define FOS_VALIDITY_STUCK 256

// Validity: there was no sample.
#define FOS_VALIDITY_MISSING 512

// Validity: the model does not have this axis, or there is no model; nothing was taken out.
#define FOS_VALIDITY_NOT_MODELLED 1024

// Validity: at rest the three accelerometers together, corrected, were further from gravity than as measured: the
// model was fitted to something else. It stays until a rest of some seconds shows otherwise.
#define FOS_VALIDITY_AWAY_FROM_GRAVITY 2048

// Fault, as all of them since the sample before: a transfer over the bus failed.
#define FOS_FAULT_BUS 1

// Fault: the sensor's FIFO ran over; samples are lost.
#define FOS_FAULT_OVERRUN 2

// Fault: samples are missing; fos_raw_sample.skipped says how many. The hub sets it itself where that is more than
// none.
#define FOS_FAULT_GAP 4

// Fault: the sensor had been reset, or was set up anew.
#define FOS_FAULT_RESET 8

// Fault: the sensor does not say that it is the part it should be.
#define FOS_FAULT_WRONG_PART 16

// Fault: all axes have repeated the same codes for longer than noise allows.
#define FOS_FAULT_STUCK 32

// Fault: at least one axis is at full scale. The hub sets it itself.
#define FOS_FAULT_SATURATED 64

// Fault: the thermometer says that it has nothing to say.
#define FOS_FAULT_TEMPERATURE 128

// Fault: the sensor's true sample rate is further than 1 % from the model's, or the clock that tells was set back.
// The hub sets it itself.
#define FOS_FAULT_RATE 256

// The codes are as the sensor gives them.
#define FOS_VALUES_RAW 0

// The codes are after a correction by the factory or the driver.
#define FOS_VALUES_FACTORY_CORRECTED 1

// Drift: the mean of the innovation has shifted.
#define FOS_DRIFT_MEAN 1

// Drift: the variance of the innovation has grown.
#define FOS_DRIFT_VARIANCE 2

// Bytes that are enough for a hub on every target: for memory that is reserved when compiling.
#define FOS_HUB_BYTES 7168

// An alignment that is enough for a hub on every target, in bytes.
#define FOS_HUB_ALIGN 8

// Bytes that every frame of telemetry fits.
#define FOS_TELEMETRY_BYTES 512

// What a call came to. Every function says which of these it returns, and what that means for it.
enum fos_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Done.
    FOS_STATUS_OK = 0,
    // A pointer is NULL that must not be.
    FOS_STATUS_NULL = 1,
    // A pointer is not aligned for what it should lead to.
    FOS_STATUS_MISALIGNED = 2,
    // A number stands for nothing, is not finite, or describes memory that cannot be.
    FOS_STATUS_ARGUMENT = 3,
    // The memory or buffer handed in is too small.
    FOS_STATUS_NO_ROOM = 4,
    // The loaded model has no such quantity or axis.
    FOS_STATUS_NOT_IN_MODEL = 5,
    // It is not known yet.
    FOS_STATUS_NOT_KNOWN = 6,
    // Loading: fewer bytes than the image has.
    FOS_STATUS_TRUNCATED = 7,
    // Loading: it does not start as a model image does.
    FOS_STATUS_NOT_AN_IMAGE = 8,
    // Loading: an image of a format version, or with flags, that this library does not know.
    FOS_STATUS_OTHER_VERSION = 9,
    // Loading: more bytes than the image, or a part of it, has.
    FOS_STATUS_TRAILING_BYTES = 10,
    // Loading: the checksum does not match.
    FOS_STATUS_DAMAGED = 11,
    // Loading: the checksum is right, but what it covers is not a model that can be run.
    FOS_STATUS_UNUSABLE = 12,
    // Loading: the model needs more than FOS_MAX_INPUTS, FOS_MAX_TERMS or FOS_MAX_HISTORY.
    FOS_STATUS_TOO_LARGE = 13,
    // Loading: the model was fitted on raw values and the sensor gives corrected ones, or the other way round: a
    // correction would be applied twice, or not at all.
    FOS_STATUS_OTHER_VALUES = 14,
    // Loading: the model was fitted at a sample period that is further than 10 % from the sensor's.
    FOS_STATUS_OTHER_PERIOD = 15,
    // Loading: an axis of the model is none of the sensor's six, or is there twice.
    FOS_STATUS_OTHER_AXIS = 16,
    // Loading: a quantity of the model is measured by an axis that is none of the sensor's six.
    FOS_STATUS_OTHER_QUANTITY = 17,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum fos_status fos_status;
#else
typedef int32_t fos_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// One sensor of six axes and its model. It lives in memory of the caller's, from fos_hub_init() until the caller uses
// that memory for something else; there is nothing to free. It must not be copied or moved.
typedef struct fos_hub fos_hub;

// What the codes of a sensor mean, as it is set up.
typedef struct fos_scales {
    // Of an accelerometer's code, m/s^2; positive.
    float accel_mps2;
    // Of a gyro's code, rad/s; positive.
    float gyro_rads;
    // Of the thermometer's code, K; 0 if there is none.
    float temperature_k;
    // What the thermometer's code 0 stands for, degrees Celsius.
    float temperature_zero_c;
    // Sample period that the sensor is set to, s; positive.
    double period_s;
    // FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
    uint8_t values;
} fos_scales;

// What a sensor gave at one instant.
typedef struct fos_raw_sample {
    // Sample periods without a sample before this one.
    uint32_t skipped;
    // Codes of the accelerometers x, y, z. A magnitude of 32767 and more is full scale.
    int16_t accel[3];
    // Codes of the gyros x, y, z. A magnitude of 32767 and more is full scale.
    int16_t gyro[3];
    // Code of the thermometer.
    int16_t temperature;
    // FOS_FAULT_... since the sample before; other bits are ignored.
    uint16_t faults;
    // 0 if the code of the thermometer is not valid, anything else if it is.
    uint8_t has_temperature;
} fos_raw_sample;

// One corrected sample. Every number in it is finite but an innovation or a temperature that is not known: that is
// NaN. Units: m/s^2 for accelerometers, rad/s for gyros. Arrays of six are in the order FOS_AX to FOS_GZ.
typedef struct fos_output {
    // Sample periods since the hub took its scales; wraps.
    uint32_t tick;
    // As the sensor gave it, m/s^2, rad/s.
    float measured[6];
    // With the predicted error taken out, m/s^2, rad/s.
    float corrected[6];
    // Measured minus predicted error, m/s^2, rad/s; NaN where the true value is not known.
    float innovation[6];
    // Temperature of the sensor, degrees Celsius; NaN where it is not known.
    float temperature_c;
    // What speaks against trusting each axis: FOS_VALIDITY_...; 0 if nothing does.
    uint16_t validity[6];
    // What went wrong on the way from the sensor, and with its clock: FOS_FAULT_...; 0 if nothing did.
    uint16_t faults;
    // 1 if the unit counts as still, else 0.
    uint8_t still;
    // 1 if the model has stopped fitting on at least one axis (fos_hub_drift says which), else 0.
    uint8_t drift;
} fos_output;

// A quantity that the application gives: one of the numbers that follow.
typedef uint8_t fos_quantity;

// Whether the unit is still: one of FOS_MOTION_DETECT, FOS_MOTION_MOVING, FOS_MOTION_STILL.
typedef uint8_t fos_motion;

// The hub finds out, by the limits in the model; a model without limits takes the unit to move always.
#define FOS_MOTION_DETECT 0

// It moves: the model coasts on its own prediction.
#define FOS_MOTION_MOVING 1

// It is still: the model follows the measured error.
#define FOS_MOTION_STILL 2

// Supply voltage, V.
#define FOS_QUANTITY_SUPPLY_V 0

// Processor load, %.
#define FOS_QUANTITY_LOAD_PCT 1

// Magnetic field x, uT.
#define FOS_QUANTITY_MAGNETIC_X_UT 2

// Magnetic field y, uT.
#define FOS_QUANTITY_MAGNETIC_Y_UT 3

// Magnetic field z, uT.
#define FOS_QUANTITY_MAGNETIC_Z_UT 4

// True value of axis i is FOS_QUANTITY_REFERENCE + i, m/s^2 or rad/s.
#define FOS_QUANTITY_REFERENCE 16

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// A status in words, for a log; "unknown status" for a number that is none. Never NULL; the text is static.
const char *fos_status_text(int32_t status);

// One FOS_VALIDITY_... in words, for a log: "valid" for 0, "unknown validity" for what is not exactly one of them.
// Never NULL; the text is static.
const char *fos_validity_text(uint16_t bit);

// Version of the library's interface: FOS_API_VERSION of the header that belongs to it.
uint32_t fos_api_version(void);

// Version of the library, as "0.1.0". Never NULL; the text is static.
const char *fos_version(void);

// Bytes that a hub takes, at most FOS_HUB_BYTES.
size_t fos_hub_size(void);

// Alignment that a hub takes, in bytes, at most FOS_HUB_ALIGN.
size_t fos_hub_align(void);

// Makes a hub without a model, for a sensor with these scales, in `memory` of `size` bytes; what was there before
// does not matter. `*out` is then the hub, at the start of `memory`. `scales` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `scales` or `out`.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_hub_size().
// - FOS_STATUS_ARGUMENT: a scale or the period is not finite or has the wrong sign, `values` stands for nothing, or no
//   memory at `memory` can have `size` bytes.
//
// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
fos_status fos_hub_init(void *memory, size_t size, const struct fos_scales *scales, struct fos_hub **out);

// Takes a model image of exactly `length` bytes; history and inputs start anew, clocks go on from fos_hub_init. The
// image need not be aligned, and is not needed afterwards.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL: `hub` or `image`. FOS_STATUS_MISALIGNED: `hub`. FOS_STATUS_ARGUMENT: no memory at `image` can
//   have `length` bytes. The hub is then as before.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_OTHER_QUANTITY, as said there. The hub then has no model, also if it had one
//   before: it corrects nothing, and every output says so.
fos_status fos_hub_load(struct fos_hub *hub, const uint8_t *image, size_t length);

// Corrects one sample; in the order of time, every one exactly once. `*raw` is read before `*output` is written.
//
// - FOS_STATUS_OK: with or without a model. It says nothing of the values: look at `validity` and `faults` of the
//   output.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `raw` or `output`. The sample counts as not given, `*output` is as
//   before.
fos_status fos_hub_update(struct fos_hub *hub, const struct fos_raw_sample *raw, struct fos_output *output);

// What a logged quantity is from now on, in its unit; to be called before the sample that it belongs to. Temperature
// and the six axes are not given: the sensor measures them. Until a quantity is given, and while it is NaN or
// infinite, the axes that use it say FOS_VALIDITY_INPUT_NOT_FINITE. Loading a model forgets it.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model does not use it. That does no harm.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
// - FOS_STATUS_ARGUMENT: `quantity` stands for nothing.
fos_status fos_hub_give(struct fos_hub *hub, fos_quantity quantity, float value);

// As fos_hub_give(), for the `k`-th of those quantities of the model that the application gives, from 0, in the
// model's order: for one that has only a name. Those that the sensor measures (temperature, the six axes) are not
// counted.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model has no such quantity.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_give_application(struct fos_hub *hub, size_t k, float value);

// Whether the unit is still, from the next sample on, where the application knows; FOS_MOTION_DETECT, as at first,
// leaves that to the hub.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
// - FOS_STATUS_ARGUMENT: `motion` stands for nothing.
fos_status fos_hub_set_motion(struct fos_hub *hub, fos_motion motion);

// What the application's clock shows, us since whenever, now that all samples up to now were given. From it the
// sensor's true sample rate is found; to be called after every batch of samples. A clock that goes back starts the
// measurement anew.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_clock(struct fos_hub *hub, uint64_t now_us);

// The sensor's true sample rate by the application's clock, in Hz.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: the first 10 s without a fault are not over; `*rate_hz` is NaN.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `rate_hz`.
fos_status fos_hub_rate_hz(const struct fos_hub *hub, float *rate_hz);

// Whether the model of an axis, FOS_AX to FOS_GZ, has stopped fitting: `*drift` is 0, or FOS_DRIFT_MEAN,
// FOS_DRIFT_VARIANCE or both. Axes are watched in turn, 200 samples each, while their innovation is known. What was
// found stays until fos_hub_restart_watch() or fos_hub_load().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model does not have the axis; `*drift` is 0.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `drift`.
// - FOS_STATUS_ARGUMENT: `axis` is not less than FOS_AXES.
fos_status fos_hub_drift(const struct fos_hub *hub, size_t axis, uint8_t *drift);

// Forgets that the model has stopped fitting, and tests anew.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_restart_watch(struct fos_hub *hub);

// Writes the frame that says what the samples hold: `*used` bytes of `buffer`, to be sent as they are, before the
// first sample and again every minute or so for those who join late. `image` is the image that the hub has loaded:
// it has the names of the quantities. Without a model `image` may be NULL and `length` 0.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes, or the names of the quantities take more than
//   400.
// - FOS_STATUS_NULL: `hub`, `buffer`, `used`, or `image` where `length` is not 0. FOS_STATUS_MISALIGNED: `hub` or
//   `used`.
// - FOS_STATUS_ARGUMENT: no memory there can have `length` or `capacity` bytes.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: `image`, as for fos_hub_load().
//
// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to, and what is in
// `buffer` is not to be sent.
fos_status fos_telemetry_start(const struct fos_hub *hub,
                               const uint8_t *image,
                               size_t length,
                               uint8_t *buffer,
                               size_t capacity,
                               size_t *used);

// Writes the frame of the latest sample: `*used` bytes of `buffer`, to be sent as they are.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes.
// - FOS_STATUS_NULL: `hub`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `hub` or `used`.
// - FOS_STATUS_ARGUMENT: no memory there can have `capacity` bytes.
//
// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to, and what is in
// `buffer` is not to be sent.
fos_status fos_telemetry_sample(const struct fos_hub *hub, uint8_t *buffer, size_t capacity, size_t *used);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FOS_H */
