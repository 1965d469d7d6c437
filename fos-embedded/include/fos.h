/*
 * fos: removes the bias drift from the samples of a six-axis inertial sensor, with a model fitted beforehand.
 *
 *     static uint64_t memory[FOS_HUB_BYTES / 8];
 *     fos_hub *hub;
 *     fos_status status = fos_hub_init(memory, sizeof memory, &scales, &hub);
 *     if (status == FOS_STATUS_OK)
 *         status = fos_hub_load(hub, image, image_length);
 *     if (status != FOS_STATUS_OK)
 *         return report(status); // or continue: without a model the hub corrects nothing, and flags every output
 *     for (;;) {
 *         read_sensor(&raw);
 *         (void)fos_hub_update(hub, &raw, &output); // fails only on NULL and misaligned pointers
 *         use(&output); // flags: output.validity, output.faults
 *     }
 *
 * Rules for every function:
 *
 * - Memory belongs to the caller. Nothing is allocated, and apart from the memory of the hub itself nothing that is passed
 *   is used after the call. A pointer must point to one object of its type, or to as many bytes as the length next to it
 *   states; these must not overlap the hub. A `fos_hub *` must come from fos_hub_init(). None of this can be checked here.
 *   The same applies to streams and fos_streams_init(), and to a store and fos_store_init(); a store also uses the
 *   functions and the context of its flash later.
 * - Checked are NULL, alignment, impossible lengths and invalid numbers. A rejected call returns a status and has no effect
 *   except as documented. No function panics or aborts: the linker proves it for all functions but those of the store,
 *   which are tested with damaged flash. No function waits, except for the functions of a flash.
 * - Threads: a hub (or streams, or a store) must be in one call at a time; calls from an interrupt and a task need a lock.
 *   Different hubs are independent: there is no global state. Functions without a hub can be called at any time.
 * - The comment of every number has its unit: SI, but degrees Celsius. An interrupt that calls fos_hub_update() must save
 *   the registers of the floating-point unit, if there is one.
 *
 * Generated from fos-embedded/src/c_api; do not edit. FOS_WRITE_HEADER=1 cargo test -p fos-embedded --test device c_header::
 */

#ifndef FOS_H
#define FOS_H

#include <stddef.h>
#include <stdint.h>

// Version of this interface, incremented with every addition. Existing declarations never change, so a program compiled
// with this header links and runs with every library whose fos_api_version() is this or higher.
#define FOS_API_VERSION 1

// Number of axes of a sensor, in the order of every array of six: accelerometer x, y, z, then gyro x, y, z.
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

// Largest number of inputs, and of logged quantities, of a model.
#define FOS_MAX_INPUTS 16

// Largest number of terms of a model, over all axes.
#define FOS_MAX_TERMS 128

// Values in the history of a hub; a model needs (longest lag) x (inputs + axes) + inputs.
#define FOS_MAX_HISTORY 256

// Validity: no reason against the value.
#define FOS_VALIDITY_VALID 0

// Validity: the history is not full yet; only the part of the error that inputs explain is subtracted.
#define FOS_VALIDITY_WARMING_UP 1

// Validity: part of the history is the model's own prediction; normal in motion and for a few samples after it.
#define FOS_VALIDITY_OWN_HISTORY 2

// Validity: the motion has lasted longer than the model was validated for; the predicted part fades out.
#define FOS_VALIDITY_COASTING_TOO_LONG 4

// Validity: the error is far outside its fitted range; it was limited.
#define FOS_VALIDITY_OUTPUT_OUT_OF_RANGE 8

// Validity: an input, or the part that inputs explain, is outside its fitted range; the edge of the range was used.
#define FOS_VALIDITY_INPUT_OUT_OF_RANGE 16

// Validity: the measured value is not finite; the previous corrected value is repeated.
#define FOS_VALIDITY_NOT_FINITE 32

// Validity: a logged quantity is not finite or was never given; its last finite value was used.
#define FOS_VALIDITY_INPUT_NOT_FINITE 64

// Validity: the measured value is at full scale.
#define FOS_VALIDITY_SATURATED 128

// Validity: the measured value has repeated for longer than noise allows.
#define FOS_VALIDITY_STUCK 256

// Validity: there was no sample.
#define FOS_VALIDITY_MISSING 512

// Validity: the model does not have this axis, or there is no model; nothing was subtracted.
#define FOS_VALIDITY_NOT_MODELLED 1024

// Validity: at rest, the corrected vector of the three accelerometers was further from gravity than the measured one: the
// model was fitted to other data. Persists until a rest of a few seconds passes the check.
#define FOS_VALIDITY_AWAY_FROM_GRAVITY 2048

// Fault (all faults refer to the time since the previous sample): a bus transfer failed.
#define FOS_FAULT_BUS 1

// Fault: the FIFO of the sensor overran; samples were lost.
#define FOS_FAULT_OVERRUN 2

// Fault: samples are missing; fos_raw_sample.skipped holds their number. The hub sets it itself if that is above 0.
#define FOS_FAULT_GAP 4

// Fault: the sensor was reset or set up again, or the clock of its timestamps was set back.
#define FOS_FAULT_RESET 8

// Fault: the identity of the sensor does not match the expected part.
#define FOS_FAULT_WRONG_PART 16

// Fault: all axes have repeated the same codes for longer than noise allows.
#define FOS_FAULT_STUCK 32

// Fault: at least one axis is at full scale. The hub sets it itself.
#define FOS_FAULT_SATURATED 64

// Fault: the thermometer reports an invalid value.
#define FOS_FAULT_TEMPERATURE 128

// Fault: the true sampling rate of the sensor differs from that of the model by more than 1 %, or the application's clock
// was set back. The hub sets it itself.
#define FOS_FAULT_RATE 256

// Kind of values: raw sensor output.
#define FOS_VALUES_RAW 0

// Kind of values: corrected by the factory calibration or the driver.
#define FOS_VALUES_FACTORY_CORRECTED 1

// Drift: the mean of the innovation has shifted.
#define FOS_DRIFT_MEAN 1

// Drift: the variance of the innovation has increased.
#define FOS_DRIFT_VARIANCE 2

// Bytes that suffice for a hub on every target, for memory reserved at compile time.
#define FOS_HUB_BYTES 7168

// Alignment that suffices for a hub on every target, in bytes.
#define FOS_HUB_ALIGN 8

// Bytes that suffice for every telemetry frame.
#define FOS_TELEMETRY_BYTES 512

// Capacity of the queues of gyros and accelerometers, samples each; a batch must fit.
#define FOS_STREAMS_DEPTH 64

// Bytes that suffice for streams on every target, for memory reserved at compile time.
#define FOS_STREAMS_BYTES 3584

// Alignment that suffices for streams on every target, in bytes.
#define FOS_STREAMS_ALIGN 8

// Longest image in a store of six or more pages, bytes: one page minus the overhead of the store. A store of four or five
// pages holds images of up to half a page, 2027 bytes.
#define FOS_STORE_IMAGE_BYTES 4067

// Bytes that suffice for a store on every target, for memory reserved at compile time.
#define FOS_STORE_BYTES 4224

// Alignment that suffices for a store on every target, in bytes.
#define FOS_STORE_ALIGN 8

// Result of a call. Every function lists the values that it returns, with their meaning.
enum fos_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Success.
    FOS_STATUS_OK = 0,
    // A required pointer is NULL.
    FOS_STATUS_NULL = 1,
    // A pointer is not aligned for its type.
    FOS_STATUS_MISALIGNED = 2,
    // A number is invalid or not finite, or describes an impossible memory range.
    FOS_STATUS_ARGUMENT = 3,
    // The memory or buffer passed in is too small.
    FOS_STATUS_NO_ROOM = 4,
    // The loaded model has no such quantity or axis.
    FOS_STATUS_NOT_IN_MODEL = 5,
    // The value is not known yet.
    FOS_STATUS_NOT_KNOWN = 6,
    // Loading: fewer bytes than the image has.
    FOS_STATUS_TRUNCATED = 7,
    // Loading: the bytes do not start like a model image.
    FOS_STATUS_NOT_AN_IMAGE = 8,
    // Loading: the format version or a flag of the image is unknown to this library.
    FOS_STATUS_OTHER_VERSION = 9,
    // Loading: more bytes than the image, or a part of it, should have.
    FOS_STATUS_TRAILING_BYTES = 10,
    // Loading: the checksum does not match.
    FOS_STATUS_DAMAGED = 11,
    // Loading: the checksum is correct, but the contents are not a usable model.
    FOS_STATUS_UNUSABLE = 12,
    // Loading: the model needs more than FOS_MAX_INPUTS, FOS_MAX_TERMS or FOS_MAX_HISTORY.
    FOS_STATUS_TOO_LARGE = 13,
    // Loading: the model was fitted on raw values and the sensor gives corrected ones, or the reverse: a correction would
    // be applied twice, or not at all.
    FOS_STATUS_OTHER_VALUES = 14,
    // Loading: the sample period of the model differs from that of the sensor by more than 10 %.
    FOS_STATUS_OTHER_PERIOD = 15,
    // Loading: an axis of the model is not one of the sensor's six, or occurs twice.
    FOS_STATUS_OTHER_AXIS = 16,
    // Loading: a quantity of the model is measured by an axis that is not one of the sensor's six.
    FOS_STATUS_OTHER_QUANTITY = 17,
    // Streams: the timestamp does not increase, or a value is not finite.
    FOS_STATUS_NOT_TAKEN = 18,
    // Store: a function of the flash failed, or the contents cannot be repaired.
    FOS_STATUS_FLASH = 19,
    // Store: the image was written but did not read back: worn flash.
    FOS_STATUS_VERIFY_FAILED = 20,
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

// One six-axis sensor and its model. The hub lives in memory of the caller, from fos_hub_init() until the caller reuses
// that memory; there is nothing to free. It must not be copied or moved.
typedef struct fos_hub fos_hub;

// Model images in flash: two slots, of which the newest valid one is used. A save is written to the slot that is not in use
// and read back. It survives power loss: the previous or the new image remains valid, and after a save the previous one
// is still available for a rollback. The store lives in memory of the caller, like a hub; the images stay in the flash.
typedef struct fos_store fos_store;

// Resamples gyros, accelerometers and a thermometer with separate timestamps to samples of one sensor, for
// fos_hub_update_si(). The streams live in memory of the caller, like a hub.
//
// The gyros lead: every gyro sample becomes a sample of the hub. Accelerometers are interpolated between their two
// neighbours, and missing where a sample was lost. The temperature is the newest at or before the gyro sample, and missing
// if older than three of its periods. Missing values are NaN, which the hub flags. `skipped` follows from the timestamps. A
// sample that came faster than the period, because another client requested a faster rate, is passed over and counted.
// Streams may arrive in any order between streams and in any batches, with the same result. When the clock was set back,
// which is detected after 8 samples, the next sample has FOS_FAULT_RESET and the 7 rejected ones as skipped.
//
// Timestamps are in ns of one clock with any origin; the caller corrects offsets between clocks.
typedef struct fos_streams fos_streams;

// Scales of the codes of a sensor as configured, its sample period and kind of values.
typedef struct fos_scales {
    // Size of one code of the accelerometers, m/s^2; positive.
    float accel_mps2;
    // Size of one code of the gyros, rad/s; positive.
    float gyro_rads;
    // Size of one code of the thermometer, K; 0 if there is none.
    float temperature_k;
    // Temperature at code 0 of the thermometer, degrees Celsius.
    float temperature_zero_c;
    // Sample period that the sensor is set to, s; positive.
    double period_s;
    // FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
    uint8_t values;
} fos_scales;

// Codes of a sensor at one instant.
typedef struct fos_raw_sample {
    // Number of sample periods without a sample before this one.
    uint32_t skipped;
    // Codes of the accelerometers x, y, z; full scale from a magnitude of 32767.
    int16_t accel[3];
    // Codes of the gyros x, y, z; full scale from a magnitude of 32767.
    int16_t gyro[3];
    // Code of the thermometer.
    int16_t temperature;
    // FOS_FAULT_... since the previous sample; other bits are ignored.
    uint16_t faults;
    // 0 if the code of the thermometer is invalid, any other value if it is valid.
    uint8_t has_temperature;
} fos_raw_sample;

// One corrected sample. Corrected values are always finite. NaN stands for an unknown innovation or temperature, and for a
// measured value that the source did not give. Units: m/s^2 for accelerometers, rad/s for gyros. Arrays of six are in the
// order FOS_AX to FOS_GZ.
typedef struct fos_output {
    // Number of sample periods since fos_hub_init(); wraps.
    uint32_t tick;
    // Measured values, m/s^2, rad/s; after fos_hub_update_si() NaN or infinite if the sample was.
    float measured[6];
    // Measured values minus predicted error, m/s^2, rad/s.
    float corrected[6];
    // Measured error minus predicted error, m/s^2, rad/s; NaN if the true value is not known.
    float innovation[6];
    // Temperature of the sensor, degrees Celsius; NaN if not known.
    float temperature_c;
    // Reasons not to trust each axis: FOS_VALIDITY_...; 0 if there is none.
    uint16_t validity[6];
    // Faults on the way from the sensor, and of its clock: FOS_FAULT_...; 0 if there is none.
    uint16_t faults;
    // 1 if the device counts as still, else 0.
    uint8_t still;
    // 1 if the model no longer fits on at least one axis (see fos_hub_drift()), else 0.
    uint8_t drift;
} fos_output;

// A sample in SI units, for sources that give values or codes of more than 16 bits. NaN and infinite values count as
// missing and are flagged in the output.
typedef struct fos_si_sample {
    // Number of sample periods without a sample before this one.
    uint32_t skipped;
    // Specific force x, y, z, m/s^2.
    float accel[3];
    // Angular rate x, y, z, rad/s.
    float gyro[3];
    // Temperature of the sensor, degrees Celsius; NaN if not known.
    float temperature_c;
    // FOS_FAULT_... since the previous sample; other bits are ignored.
    uint16_t faults;
} fos_si_sample;

// One corrected sample with the predicted error.
typedef struct fos_si_output {
    // Output as from fos_hub_update().
    struct fos_output output;
    // Predicted error, offset included, m/s^2, rad/s: the bias that a phone's framework requests. 0 on axes without a
    // model.
    float predicted[6];
} fos_si_output;

// A logged quantity that the application gives: FOS_QUANTITY_...
typedef uint8_t fos_quantity;

// Motion state of the device: FOS_MOTION_DETECT, FOS_MOTION_MOVING or FOS_MOTION_STILL.
typedef uint8_t fos_motion;

// Nominal periods of the streams, ns.
typedef struct fos_stream_periods {
    // Period of the gyros, equal to that of the hub's scales; not 0.
    uint64_t gyro_ns;
    // Period of the accelerometers; not 0.
    uint64_t accel_ns;
    // Period of the thermometer; 0 if there is none.
    uint64_t temperature_ns;
} fos_stream_periods;

// Counts of one stream: samples that did not enter a sample of the hub unchanged. Each saturates.
typedef struct fos_stream_count {
    // Samples rejected because their timestamp did not increase.
    uint32_t refused;
    // Samples with a value that is not finite.
    uint32_t not_finite;
    // Samples dropped because the queue was full or the clock was set back.
    uint32_t dropped;
    // Number of times the clock was set back.
    uint32_t set_back;
    // Samples returned or passed over without a value of this stream; 0 for the gyros, see `not_finite`.
    uint32_t missing;
} fos_stream_count;

// Counts of all streams.
typedef struct fos_stream_counts {
    // Counts of the gyros.
    struct fos_stream_count gyro;
    // Counts of the accelerometers.
    struct fos_stream_count accel;
    // Counts of the thermometer.
    struct fos_stream_count temperature;
    // Gyro samples passed over because they came faster than the period.
    uint32_t passed_over;
} fos_stream_counts;

// Flash for a store: a range, and functions of the application that access it. The functions return 0 on success and any
// other value on failure; they must not call the store. `context` is passed to them unchanged.
typedef struct fos_flash {
    // Passed to the following functions; may be NULL.
    void *context;
    // Reads `length` bytes at `address`, both multiples of 8.
    int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
    // Writes `length` bytes at `address`, both multiples of 8, at most once after every erase. Parts with write words of
    // 16 bytes or more are not supported.
    int32_t (*write)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
    // Erases `length` bytes at `address` to 0xff: 4096 bytes, or one sector if sectors are larger.
    int32_t (*erase)(void *context, uint32_t address, uint32_t length);
    // Start address of the range; the start of a sector.
    uint32_t address;
    // Length of the range, bytes: whole pages, at least four; at least six for images of more than 2027 bytes. A page is
    // 4096 bytes, or one sector if sectors are larger.
    uint32_t capacity;
    // Size of a sector, the smallest unit of erasing, bytes: a divisor of 4096, or a larger multiple of 8.
    uint32_t erase_size;
} fos_flash;

// Motion: detected by the hub with the limits in the model; without limits the device counts as moving.
#define FOS_MOTION_DETECT 0

// Motion: the device moves; the model coasts on its own prediction.
#define FOS_MOTION_MOVING 1

// Motion: the device is still; the model tracks the measured error.
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

// True value of an axis, m/s^2 or rad/s; FOS_QUANTITY_REFERENCE + i for axis i.
#define FOS_QUANTITY_REFERENCE 16

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Text of a status, for a log; "unknown status" for other numbers. Never NULL; the text is static.
const char *fos_status_text(int32_t status);

// Text of one FOS_VALIDITY_..., for a log: "valid" for 0, "unknown validity" for anything but exactly one of them. Never
// NULL; the text is static.
const char *fos_validity_text(uint16_t bit);

// Version of the library's interface: FOS_API_VERSION of the matching header.
uint32_t fos_api_version(void);

// Version of the library, for example "0.1.0". Never NULL; the text is static.
const char *fos_version(void);

// Size of a hub in bytes, at most FOS_HUB_BYTES.
size_t fos_hub_size(void);

// Alignment of a hub in bytes, at most FOS_HUB_ALIGN.
size_t fos_hub_align(void);

// Computes the scales of a source that gives values in SI units, for fos_hub_init(). `accel_mps2` is the full scale of the
// accelerometers in m/s^2, `gyro_rads` that of the gyros in rad/s, FLT_MAX if there is none; `period_s` is the sample
// period in seconds; `values` is FOS_VALUES_RAW or FOS_VALUES_FACTORY_CORRECTED.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `out`.
// - FOS_STATUS_ARGUMENT: a full scale or the period is not finite, 0 or negative, or too small to be divided into 32767
//   codes, or `values` is invalid. `*out` is unchanged.
fos_status fos_scales_of_full_scale(float accel_mps2,
                                    float gyro_rads,
                                    double period_s,
                                    uint8_t values,
                                    struct fos_scales *out);

// Creates a hub without a model, for a sensor with these scales, in `memory` of `size` bytes, whose contents are
// overwritten. `*out` then points to the hub, at the start of `memory`. `scales` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `scales` or `out`.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_hub_size().
// - FOS_STATUS_ARGUMENT: a scale or the period is not finite or has the wrong sign, `values` is invalid, or `size` is
//   impossible at that address.
//
// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
fos_status fos_hub_init(void *memory, size_t size, const struct fos_scales *scales, struct fos_hub **out);

// Loads a model image of exactly `length` bytes. History and inputs are reset; the clocks of the inputs continue from
// fos_hub_init(). The image need not be aligned and is not needed afterwards.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL: `hub` or `image`. FOS_STATUS_MISALIGNED: `hub`. FOS_STATUS_ARGUMENT: `length` is impossible at that
//   address. The hub is then unchanged.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_OTHER_QUANTITY: see there. The hub then has no model, even if it had one before: it
//   corrects nothing and flags every output with FOS_VALIDITY_NOT_MODELLED.
fos_status fos_hub_load(struct fos_hub *hub,
                        const uint8_t *image,
                        size_t length);

// Corrects one sample. Pass every sample exactly once, in the order of time. `*raw` is read before `*output` is written.
//
// - FOS_STATUS_OK: with or without a model. It does not validate the values: check `validity` and `faults` of the output.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `raw` or `output`. The sample is not processed and `*output` is
//   unchanged.
fos_status fos_hub_update(struct fos_hub *hub,
                          const struct fos_raw_sample *raw,
                          struct fos_output *output);

// Corrects one sample in SI units; otherwise the same as fos_hub_update(). Full scale, period and kind of values are those
// of the hub's scales, see fos_scales_of_full_scale(). Both functions may be used with the same hub. `*sample` is read
// before `*output` is written.
//
// - FOS_STATUS_OK: with or without a model. It does not validate the values: check `validity` and `faults` of the output.
//   An axis without a finite value has FOS_VALIDITY_NOT_FINITE; without a temperature, axes whose model uses it have
//   FOS_VALIDITY_INPUT_NOT_FINITE.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`, `sample` or `output`. The sample is not processed and `*output` is
//   unchanged.
fos_status fos_hub_update_si(struct fos_hub *hub,
                             const struct fos_si_sample *sample,
                             struct fos_si_output *output);

// Sets a logged quantity from now on, in its unit; call it before the sample that the value belongs to. Temperature and the
// six axes come from the sensor. Until a quantity is set, and while it is NaN or infinite, the axes that use it have
// FOS_VALIDITY_INPUT_NOT_FINITE. Loading a model resets it.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model does not use it; the value is ignored.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
// - FOS_STATUS_ARGUMENT: `quantity` is invalid.
fos_status fos_hub_give(struct fos_hub *hub,
                        fos_quantity quantity,
                        float value);

// Sets the `k`-th quantity, from 0, of those that the application gives, in the model's order; for quantities that have
// only a name. Quantities that the sensor measures (temperature, the six axes) are not counted. Otherwise the same as
// fos_hub_give().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model has no such quantity.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_give_application(struct fos_hub *hub, size_t k, float value);

// Sets the motion state from the next sample on, if the application knows it. FOS_MOTION_DETECT, the initial value, leaves
// it to the hub.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
// - FOS_STATUS_ARGUMENT: `motion` is invalid.
fos_status fos_hub_set_motion(struct fos_hub *hub,
                              fos_motion motion);

// Passes the time of the application's clock, in us since any origin, after all samples up to now were passed. Call it
// after every batch of samples; it measures the true sampling rate of the sensor. A clock that is set back restarts the
// measurement.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_clock(struct fos_hub *hub, uint64_t now_us);

// True sampling rate of the sensor by the application's clock, in Hz.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: fewer than 10 s without a fault have passed; `*rate_hz` is NaN.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `rate_hz`.
fos_status fos_hub_rate_hz(const struct fos_hub *hub, float *rate_hz);

// Drift of the model of an axis, FOS_AX to FOS_GZ: `*drift` is 0 while the model fits, otherwise FOS_DRIFT_MEAN,
// FOS_DRIFT_VARIANCE or both. The axes are monitored in turn, 200 samples each, while their innovation is known. A detected
// drift persists until fos_hub_restart_watch() or fos_hub_load().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_IN_MODEL: the model does not have the axis; `*drift` is 0.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub` or `drift`.
// - FOS_STATUS_ARGUMENT: `axis` is not less than FOS_AXES.
fos_status fos_hub_drift(const struct fos_hub *hub,
                         size_t axis,
                         uint8_t *drift);

// Clears the drift of all axes and restarts the tests.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `hub`.
fos_status fos_hub_restart_watch(struct fos_hub *hub);

// Writes the start frame, which describes the samples: `*used` bytes of `buffer`, to be sent unchanged before the first
// sample, and again about once per minute for receivers that join late. `image` is the image loaded by the hub, which has
// the names of the quantities. Without a model, `image` may be NULL and `length` 0.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes, or the names of the quantities take more than
//   400.
// - FOS_STATUS_NULL: `hub`, `buffer`, `used`, or `image` where `length` is not 0. FOS_STATUS_MISALIGNED: `hub` or
//   `used`.
// - FOS_STATUS_ARGUMENT: `length` or `capacity` is impossible at that address.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: `image` is invalid, as for fos_hub_load().
//
// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid, and `buffer` must not be sent.
fos_status fos_telemetry_start(const struct fos_hub *hub,
                               const uint8_t *image,
                               size_t length,
                               uint8_t *buffer,
                               size_t capacity,
                               size_t *used);

// Writes the frame of the latest sample: `*used` bytes of `buffer`, to be sent unchanged.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_ROOM: the frame does not fit into `capacity` bytes.
// - FOS_STATUS_NULL: `hub`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `hub` or `used`.
// - FOS_STATUS_ARGUMENT: `capacity` is impossible at that address.
//
// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid, and `buffer` must not be sent.
fos_status fos_telemetry_sample(const struct fos_hub *hub, uint8_t *buffer, size_t capacity, size_t *used);

// Size of streams in bytes, at most FOS_STREAMS_BYTES.
size_t fos_streams_size(void);

// Alignment of streams in bytes, at most FOS_STREAMS_ALIGN.
size_t fos_streams_align(void);

// Creates empty streams in `memory` of `size` bytes, whose contents are overwritten. `*out` then points to the start of
// `memory`. `periods` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `periods` or `out`.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_streams_size().
// - FOS_STATUS_ARGUMENT: a period exceeds INT64_MAX, the period of gyros or accelerometers is 0, or `size` is impossible at
//   that address.
//
// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
fos_status fos_streams_init(void *memory,
                            size_t size,
                            const struct fos_stream_periods *periods,
                            struct fos_streams **out);

// Sets the periods from the next sample on, after the requested rate of a stream has changed. `gyro_ns` must remain the
// period of the hub's scales. `periods` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `periods`.
// - FOS_STATUS_ARGUMENT: a period is invalid, as for fos_streams_init(); the periods are unchanged.
fos_status fos_streams_set_periods(struct fos_streams *streams, const struct fos_stream_periods *periods);

// Adds a gyro sample: angular rate x, y, z, rad/s. Call fos_streams_next() afterwards until it returns
// FOS_STATUS_NOT_KNOWN: a full queue drops its oldest sample.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, and the sample is rejected; or a value is not finite, and the
//   sample remains with the gyros missing. fos_streams_counts() distinguishes the two.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which points to three values.
fos_status fos_streams_gyro(struct fos_streams *streams,
                            int64_t stamp_ns,
                            const float *value);

// Adds an accelerometer sample: specific force x, y, z, m/s^2.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, or a value is not finite.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `value`, which points to three values.
fos_status fos_streams_accel(struct fos_streams *streams, int64_t stamp_ns, const float *value);

// Adds a temperature of the sensor, degrees Celsius. Add it before the gyro samples that it applies to.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_TAKEN: the timestamp does not increase, or the value is not finite.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`.
fos_status fos_streams_temperature(struct fos_streams *streams, int64_t stamp_ns, float celsius);

// Returns the next sample for fos_hub_update_si() and its timestamp, that of the gyros, once no later value can change it
// or the queue of the gyros is full.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: no further sample is ready; `*sample` and `*stamp_ns` are unchanged.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. No sample is removed.
fos_status fos_streams_next(struct fos_streams *streams,
                            struct fos_si_sample *sample,
                            int64_t *stamp_ns);

// Returns the next sample with the values available, without waiting for the accelerometers: at the end, or before a long
// sleep. Otherwise the same as fos_streams_next().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NOT_KNOWN: there is no further sample; `*sample` and `*stamp_ns` are unchanged.
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams`, `sample` or `stamp_ns`. No sample is removed.
fos_status fos_streams_flush(struct fos_streams *streams,
                             struct fos_si_sample *sample,
                             int64_t *stamp_ns);

// Counts of rejected, missing, dropped and passed-over samples since fos_streams_init().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `streams` or `counts`.
fos_status fos_streams_counts(const struct fos_streams *streams, struct fos_stream_counts *counts);

// Size of a store in bytes, at most FOS_STORE_BYTES.
size_t fos_store_size(void);

// Alignment of a store in bytes, at most FOS_STORE_ALIGN.
size_t fos_store_align(void);

// Creates a store in `memory` of `size` bytes, for the images in the flash, which is not accessed yet. `*out` then points to
// the start of `memory`. `flash` is copied.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NULL, FOS_STATUS_MISALIGNED: `memory`, `flash` or `out`; FOS_STATUS_NULL also for a function in `flash`.
// - FOS_STATUS_NO_ROOM: `size` is less than fos_store_size().
// - FOS_STATUS_ARGUMENT: the range does not consist of whole pages from the start of a sector, has fewer than four, or
//   exceeds the address space; the sector size neither divides 4096 nor is a larger multiple of 8; or `size` is impossible
//   at that address.
//
// After any status other than FOS_STATUS_OK `*out` is NULL, if `out` itself is valid.
fos_status fos_store_init(void *memory,
                          size_t size,
                          const struct fos_flash *flash,
                          struct fos_store **out);

// Stores an image of exactly `length` bytes as the newest. It takes the time of a few writes and sometimes of an erase.
// `image` must not overlap the store.
//
// - FOS_STATUS_OK: the image was written and read back.
// - FOS_STATUS_NULL: `store` or `image`. FOS_STATUS_MISALIGNED: `store`. FOS_STATUS_ARGUMENT: `length` is impossible at that
//   address.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: the image is invalid, as for fos_hub_load(). Nothing was written.
// - FOS_STATUS_NO_ROOM: the image is longer than FOS_STORE_IMAGE_BYTES, or than 2027 bytes in a store of four or five
//   pages. Nothing was written.
// - FOS_STATUS_FLASH, FOS_STATUS_VERIFY_FAILED: the previous image is still the newest; the call may be repeated.
fos_status fos_store_save(struct fos_store *store,
                          const uint8_t *image,
                          size_t length);

// Copies the newest valid image into `buffer`: `*used` bytes, for fos_hub_load().
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_MODEL: there is none. Damaged images, and those of a version that this library does not run, do not count.
// - FOS_STATUS_NO_ROOM: the image is longer than `capacity`; FOS_STORE_IMAGE_BYTES always suffice.
// - FOS_STATUS_FLASH: a function of the flash failed.
// - FOS_STATUS_NULL: `store`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `store` or `used`. FOS_STATUS_ARGUMENT:
//   `capacity` is impossible at that address.
//
// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid.
fos_status fos_store_load(struct fos_store *store,
                          uint8_t *buffer,
                          size_t capacity,
                          size_t *used);

// Copies the image before the newest into `buffer`, for a rollback after a bad update; otherwise the same as
// fos_store_load(). To make the rollback permanent, save the image: it is then the newest.
//
// - FOS_STATUS_OK
// - FOS_STATUS_NO_MODEL: there is no previous image, or it is damaged.
// - All others: as for fos_store_load().
fos_status fos_store_load_previous(struct fos_store *store, uint8_t *buffer, size_t capacity, size_t *used);

// Makes the image of a unit from the image of its part and the record of the unit, as written by `fos fleet export`: `*used`
// bytes in `buffer`, as many as the image of the part has, for fos_hub_load() and fos_store_save(). Neither must overlap
// `buffer`. Until the record is available, use the image of the part.
//
// - FOS_STATUS_OK: the model itself is checked when the image is loaded.
// - FOS_STATUS_TRUNCATED to FOS_STATUS_UNUSABLE: image or record is damaged, or the record has another number of values.
// - FOS_STATUS_OTHER_PART: the record belongs to another image.
// - FOS_STATUS_NO_ROOM: `capacity` is less than `part_length`.
// - FOS_STATUS_NULL: `part`, `record`, `buffer` or `used`. FOS_STATUS_MISALIGNED: `used`.
//   FOS_STATUS_ARGUMENT: a length is impossible at its address.
//
// After any status other than FOS_STATUS_OK `*used` is 0, if `used` itself is valid.
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
