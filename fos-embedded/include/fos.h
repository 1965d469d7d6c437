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
 *         use(&output); // flags: output.validity, output.faults
 *     }
 *
 * What holds for every function:
 *
 * - Memory is the caller's. Nothing is allocated and nothing is kept of what is passed but the memory of the hub
 *   itself. A pointer leads to one object of its type, or to as many bytes as the length beside it says; these do not
 *   overlap the hub. A `fos_hub *` is one that fos_hub_init() gave out. That much cannot be checked here. The same holds
 *   of streams and fos_streams_init(), of a store and fos_store_init().
 * - Checked is: NULL, alignment, lengths that no memory can have, numbers that stand for nothing. What is refused has a
 *   status, and nothing was done but what the function says. No function panics or aborts: the linker shows it of all but
 *   the store's, tests with damaged flash of those. None waits but for the functions of a flash.
 * - Threads: a hub (or streams, or a store) is in one call at a time; calls from an interrupt and a task need a lock of
 *   the caller's. Different hubs do not know of each other: there is no global state. Functions without a hub can be
 *   called at any time.
 * - Units are in the comment of every number: SI, but degrees Celsius. An interrupt that calls fos_hub_update() must
 *   save the registers of the floating-point unit, if there is one.
 *
 * Generated from fos-embedded/src/c_api; do not edit. FOS_WRITE_HEADER=1 cargo test -p fos-embedded --test device c_header::
 */

#ifndef FOS_H
#define FOS_H

#include <stddef.h>
#include <stdint.h>

// Version of this interface: raised with what is added. What a header before declares stays as it is, so that a program
// compiled with it links and runs unchanged: with a library whose fos_api_version() is this or more.
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

// Fault: the sensor had been reset, was set up anew, or the clock of its stamps was set back.
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

// Samples of gyros and of accelerometers that are queued: a batch must go in.
#define FOS_STREAMS_DEPTH 64

// Bytes that are enough for streams on every target: for memory that is reserved when compiling.
#define FOS_STREAMS_BYTES 3584

// An alignment that is enough for streams on every target, in bytes.
#define FOS_STREAMS_ALIGN 8

// The longest image that a store of six pages and more takes, bytes: it fits a page with what the store puts before it. A
// store of four or five pages takes half a page, 2027 bytes.
#define FOS_STORE_IMAGE_BYTES 4067

// Bytes that are enough for a store on every target: for memory that is reserved when compiling.
#define FOS_STORE_BYTES 4224

// An alignment that is enough for a store on every target, in bytes.
#define FOS_STORE_ALIGN 8

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
    // Streams: a stamp that does not increase, or a value that is not finite.
    FOS_STATUS_NOT_TAKEN = 18,
    // Store: a function of the flash failed, or what is there is beyond repair.
    FOS_STATUS_FLASH = 19,
    // Store: it was written and did not read back: worn flash.
    FOS_STATUS_NOT_KEPT = 20,
    // Store: there is no valid image.
    FOS_STATUS_NO_MODEL = 21,
    // Unit: the record belongs to the image of another part.
    FOS_STATUS_OTHER_PART = 22,
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

// Model images in flash: two slots, the newest valid one wins. A save goes into the slot that is not in use and is read
// back; whatever happens to the power meanwhile, the image before or the new one is there, and after it the one before
// can still be returned to. It lives in memory of the caller's, as a hub does; what is in the flash stays there.
typedef struct fos_store fos_store;

// Gyros, accelerometers and a thermometer, each with stamps of its own, as samples of one sensor for
// fos_hub_update_si(). It lives in memory of the caller's, as a hub does.
//
// The gyros lead: every sample of theirs is one for the hub. The accelerometers are interpolated between their two
// neighbours, and missing where a sample is lost; the temperature is the newest that is not of later, and missing where
// it is older than three of its periods. What is missing is NaN, which the hub says. `skipped` is what the stamps say;
// a sample that came faster than the period, because another client asked for a faster rate, is passed over and
// counted. Streams may come in any order between them and in any batches; the samples are the same. Where a clock is set
// back, which is certain after 8 samples, the sample says FOS_FAULT_RESET and has the 7 before as skipped.
//
// Stamps are ns of one clock, whatever it is; an offset between clocks is the caller's to add.
typedef struct fos_streams fos_streams;

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

// One corrected sample. Every number in it is finite but what is not known: an innovation, a temperature, and what was
// measured where the source gave no number. That is NaN. Units: m/s^2 for accelerometers, rad/s for gyros. Arrays of
// six are in the order FOS_AX to FOS_GZ.
typedef struct fos_output {
    // Sample periods since the hub took its scales; wraps.
    uint32_t tick;
    // As the sensor gave it, m/s^2, rad/s; of fos_hub_update_si() NaN or infinite where the sample was.
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

// The same in SI units: of a source that gives values, or codes of more than 16 bits. A value that is NaN or infinite is
// missing: the output says so.
typedef struct fos_si_sample {
    // Sample periods without a sample before this one.
    uint32_t skipped;
    // Specific force x, y, z, m/s^2.
    float accel[3];
    // Rate x, y, z, rad/s.
    float gyro[3];
    // Temperature of the sensor, degrees Celsius; NaN where it is not known.
    float temperature_c;
    // FOS_FAULT_... since the sample before; other bits are ignored.
    uint16_t faults;
} fos_si_sample;

// One corrected sample, and what was taken out of it.
typedef struct fos_si_output {
    // As of fos_hub_update().
    struct fos_output output;
    // The error that was predicted, offset included, m/s^2, rad/s: the bias that a phone's framework asks for. 0 on an
    // axis that the model does not have.
    float predicted[6];
} fos_si_output;

// A quantity that the application gives: one of the numbers that follow.
typedef uint8_t fos_quantity;

// Whether the unit is still: one of FOS_MOTION_DETECT, FOS_MOTION_MOVING, FOS_MOTION_STILL.
typedef uint8_t fos_motion;

// Nominal periods, ns.
typedef struct fos_stream_periods {
    // Of the gyros: that of the hub's scales. Not 0.
    uint64_t gyro_ns;
    // Of the accelerometers. Not 0.
    uint64_t accel_ns;
    // Of the thermometer; 0 if there is none.
    uint64_t temperature_ns;
} fos_stream_periods;

// What did not go into a sample as it came; each stays at its highest value.
typedef struct fos_stream_count {
    // Stamps that did not increase.
    uint32_t refused;
    // Samples with a value that is not finite.
    uint32_t not_finite;
    // Samples that a full queue lost, or a clock that was set back.
    uint32_t dropped;
    // Times that the clock was set back.
    uint32_t set_back;
    // Samples given, or passed over, without a value of this stream; of the gyros see `not_finite`.
    uint32_t missing;
} fos_stream_count;

// The same of all streams.
typedef struct fos_stream_counts {
    // Of the gyros.
    struct fos_stream_count gyro;
    // Of the accelerometers.
    struct fos_stream_count accel;
    // Of the thermometer.
    struct fos_stream_count temperature;
    // Samples of the gyros that came faster than their period.
    uint32_t passed_over;
} fos_stream_counts;

// Flash for a store: a range of it, and the product's functions that reach it. They return 0 when all is done, and
// anything else when it is not; they do not call the store. `context` is handed to them as it is.
typedef struct fos_flash {
    // For the functions that follow; may be NULL.
    void *context;
    // Reads `length` bytes at `address`, both multiples of 8.
    int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
    // Writes `length` bytes at `address`, both multiples of 8, once after every erase; not into words of 16 bytes and
    // more: such parts are not supported.
    int32_t (*write)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
    // Has `length` bytes at `address` read 0xff: 4096 of them, or one sector where sectors are larger.
    int32_t (*erase)(void *context, uint32_t address, uint32_t length);
    // Where the range begins: a sector.
    uint32_t address;
    // Bytes of the range: whole pages, at least four, for images of more than 2027 bytes six. A page is 4096 bytes, or one sector where sectors are larger.
    uint32_t capacity;
    // Bytes of a sector, which is erased at once: divides 4096, or is a larger multiple of 8.
    uint32_t erase_size;
} fos_flash;

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

// The scales of a source that gives values, for fos_hub_init(): the accelerometers are at full scale at `accel_mps2`,
// m/s^2, the gyros at `gyro_rads`, rad/s, where there is none at FLT_MAX; one sample every `period_s` seconds. `values` is
// FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `out`.
// - FOS_STATUS_ARGUMENT: a full scale or the period is not finite, 0 or negative, or too small to be divided into 32767
//   codes, or `values` stands for nothing. `*out` is as before.
fos_status fos_scales_of_full_scale(float accel_mps2,
                                    float gyro_rads,
                                    double period_s,
                                    uint8_t values,
                                    struct fos_scales *out);

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

// As fos_hub_update(), of a sample in SI units; full scale, period and what the values are stay those of the hub's
// scales: fos_scales_of_full_scale(). A hub may be given both in turn. `*sample` is read before `*output` is written.
//
// - FOS_STATUS_OK: with or without a model. It says nothing of the values: look at `validity` and `faults` of the
//   output. An axis without a number says FOS_VALIDITY_NOT_FINITE, a model that uses a temperature without one
//   FOS_VALIDITY_INPUT_NOT_FINITE.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `sample` or `output`. The sample counts as not given, `*output` is as
//   before.
fos_status fos_hub_update_si(struct fos_hub *hub,
                             const struct fos_si_sample *sample,
                             struct fos_si_output *output);

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

// Bytes that streams take, at most FOS_STREAMS_BYTES.
size_t fos_streams_size(void);

// Alignment that streams take, in bytes, at most FOS_STREAMS_ALIGN.
size_t fos_streams_align(void);

// Makes streams without a sample in `memory` of `size` bytes; what was there before does not matter. `*out` is then at
// the start of `memory`. `periods` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `periods` or `out`.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_streams_size().
// - FOS_STATUS_ARGUMENT: a period is more than INT64_MAX, one that must not be 0 is, or no memory at `memory` can have
//   `size` bytes.
//
// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
fos_status fos_streams_init(void *memory,
                            size_t size,
                            const struct fos_stream_periods *periods,
                            struct fos_streams **out);

// Other periods, from the next sample on: what a stream was asked for has changed. `gyro_ns` is to stay the period of the
// hub's scales. `periods` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `periods`.
// - FOS_STATUS_ARGUMENT: as of fos_streams_init(); the periods are as before.
fos_status fos_streams_set_periods(struct fos_streams *streams,
                                   const struct fos_stream_periods *periods);

// Takes a sample of the gyros: rate x, y, z, rad/s. Call fos_streams_next() after it until there is nothing more: a full
// queue loses its oldest sample.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, and nothing was done; or a value is not finite, and the sample is
//   there without gyros. fos_streams_counts() says which.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which leads to three.
fos_status fos_streams_gyro(struct fos_streams *streams,
                            int64_t stamp_ns,
                            const float *value);

// Takes a sample of the accelerometers: specific force x, y, z, m/s^2.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, or a value is not finite.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which leads to three.
fos_status fos_streams_accel(struct fos_streams *streams, int64_t stamp_ns, const float *value);

// Takes a temperature of the sensor, degrees Celsius; before the samples of the gyros that it is for.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: its stamp does not increase, or it is not finite.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`.
fos_status fos_streams_temperature(struct fos_streams *streams, int64_t stamp_ns, float celsius);

// The next sample for fos_hub_update_si(), and its stamp, that of the gyros; as soon as nothing that may still come can
// change it, or the queue of the gyros is full.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: there is nothing more yet; `*sample` and `*stamp_ns` are as before.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. Nothing is taken out.
fos_status fos_streams_next(struct fos_streams *streams, struct fos_si_sample *sample, int64_t *stamp_ns);

// As fos_streams_next(), with what there is, without waiting for the accelerometers: for the end, or before a long sleep.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: there is nothing more; `*sample` and `*stamp_ns` are as before.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. Nothing is taken out.
fos_status fos_streams_flush(struct fos_streams *streams,
                             struct fos_si_sample *sample,
                             int64_t *stamp_ns);

// What was refused, missing, lost or passed over since fos_streams_init().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `counts`.
fos_status fos_streams_counts(const struct fos_streams *streams, struct fos_stream_counts *counts);

// Bytes that a store takes, at most FOS_STORE_BYTES.
size_t fos_store_size(void);

// Alignment that a store takes, in bytes, at most FOS_STORE_ALIGN.
size_t fos_store_align(void);

// Makes a store in `memory` of `size` bytes, over the images that are in the flash, which is not yet looked at. `*out` is
// then at the start of `memory`. `flash` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `flash` or `out`; NULL: one of the functions in `flash` too.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_store_size().
// - FOS_STATUS_ARGUMENT: the range is not whole pages from the start of a sector, fewer than four or beyond the
//   addresses; a sector neither divides 4096 nor is a larger multiple of 8; or no memory at `memory` can have `size`
//   bytes.
//
// After any other status than FOS_STATUS_OK `*out` is NULL, where `out` itself can be written to.
fos_status fos_store_init(void *memory,
                          size_t size,
                          const struct fos_flash *flash,
                          struct fos_store **out);

// Stores an image of exactly `length` bytes; from then on it is the newest. It takes the time of some writes, and now and
// then of an erase. `image` does not overlap the store.
//
// - FOS_STATUS_OK: it is in the flash and was read back.
// - FOS_STATUS_NULL: `store` or `image`. FOS_STATUS_MISALIGNED: `store`. FOS_STATUS_ARGUMENT: no memory at `image` can
//   have `length` bytes.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: it is no image, as for fos_hub_load(). Nothing was written.
// - FOS_STATUS_NO_ROOM: it is longer than FOS_STORE_IMAGE_BYTES, or half a page where that is all. Nothing was written.
// - FOS_STATUS_FLASH, FOS_STATUS_NOT_KEPT: the image before is still the newest; it may be tried again.
fos_status fos_store_save(struct fos_store *store,
                          const uint8_t *image,
                          size_t length);

// Copies the newest valid image into `buffer`: `*used` bytes, for fos_hub_load().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_MODEL: there is none. What is damaged, or of a version that this library does not run, is none.
// - FOS_STATUS_NO_ROOM: it is longer than `capacity`; FOS_STORE_IMAGE_BYTES are always enough.
// - FOS_STATUS_FLASH
// - FOS_STATUS_NULL: `store`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `store` or `used`. FOS_STATUS_ARGUMENT: no memory
//   at `buffer` can have `capacity` bytes.
//
// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to.
fos_status fos_store_load(struct fos_store *store,
                          uint8_t *buffer,
                          size_t capacity,
                          size_t *used);

// As fos_store_load(), of the image before the newest: what to return to if an update proves wrong. To stay with it, save
// it: it is then the newest.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_MODEL: there is none, or it is damaged.
// - All others as of fos_store_load().
fos_status fos_store_load_previous(struct fos_store *store,
                                   uint8_t *buffer,
                                   size_t capacity,
                                   size_t *used);

// Makes the image of a unit of that of its part and the unit's record, as `fos fleet export` writes them: `*used` bytes in `buffer`, as many
// as the image of the part has, for fos_hub_load() and fos_store_save(). Neither overlaps `buffer`. Until the record is there, the image of the part
// itself serves.
//
// - FOS_STATUS_OK: whether the model can be used is found when it is loaded.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: image or record are damaged, or the record has another number of values.
// - FOS_STATUS_OTHER_PART: the record belongs to another image.
// - FOS_STATUS_NO_ROOM: `capacity` is less than `part_length`.
// - FOS_STATUS_NULL: `part`, `record`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `used`. FOS_STATUS_ARGUMENT: no memory can have
//   so many bytes.
//
// After any other status than FOS_STATUS_OK `*used` is 0, where `used` itself can be written to.
fos_status fos_image_for_unit(const uint8_t *part,
                              size_t part_length,
                              const uint8_t *record,
                              size_t record_length,
                              uint8_t *buffer,
                              size_t capacity,
                              size_t *used);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FOS_H */
