/* The layout that the compiler of C gives the structures is the one that src/c_api/values.rs asserts. Compiled only. */
#include "fos.h"

#define HOLDS(name, condition) typedef char name[(condition) ? 1 : -1]

HOLDS(scales_size, sizeof(fos_scales) == 32);
HOLDS(scales_period, offsetof(fos_scales, period_s) == 16);
HOLDS(scales_values, offsetof(fos_scales, values) == 24);
HOLDS(raw_size, sizeof(fos_raw_sample) == 24);
HOLDS(raw_accel, offsetof(fos_raw_sample, accel) == 4);
HOLDS(raw_gyro, offsetof(fos_raw_sample, gyro) == 10);
HOLDS(raw_temperature, offsetof(fos_raw_sample, temperature) == 16);
HOLDS(raw_faults, offsetof(fos_raw_sample, faults) == 18);
HOLDS(raw_has_temperature, offsetof(fos_raw_sample, has_temperature) == 20);
HOLDS(output_size, sizeof(fos_output) == 96);
HOLDS(output_measured, offsetof(fos_output, measured) == 4);
HOLDS(output_corrected, offsetof(fos_output, corrected) == 28);
HOLDS(output_innovation, offsetof(fos_output, innovation) == 52);
HOLDS(output_temperature, offsetof(fos_output, temperature_c) == 76);
HOLDS(output_validity, offsetof(fos_output, validity) == 80);
HOLDS(output_faults, offsetof(fos_output, faults) == 92);
HOLDS(output_still, offsetof(fos_output, still) == 94);
HOLDS(output_drift, offsetof(fos_output, drift) == 95);
HOLDS(status_size, sizeof(fos_status) == 4);
