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
HOLDS(si_sample_size, sizeof(fos_si_sample) == 36);
HOLDS(si_sample_accel, offsetof(fos_si_sample, accel) == 4);
HOLDS(si_sample_gyro, offsetof(fos_si_sample, gyro) == 16);
HOLDS(si_sample_temperature, offsetof(fos_si_sample, temperature_c) == 28);
HOLDS(si_sample_faults, offsetof(fos_si_sample, faults) == 32);
HOLDS(si_output_size, sizeof(fos_si_output) == 120);
HOLDS(si_output_output, offsetof(fos_si_output, output) == 0);
HOLDS(si_output_predicted, offsetof(fos_si_output, predicted) == 96);
HOLDS(periods_size, sizeof(fos_stream_periods) == 24);
HOLDS(periods_accel, offsetof(fos_stream_periods, accel_ns) == 8);
HOLDS(periods_temperature, offsetof(fos_stream_periods, temperature_ns) == 16);
HOLDS(count_size, sizeof(fos_stream_count) == 20);
HOLDS(count_not_finite, offsetof(fos_stream_count, not_finite) == 4);
HOLDS(count_dropped, offsetof(fos_stream_count, dropped) == 8);
HOLDS(count_set_back, offsetof(fos_stream_count, set_back) == 12);
HOLDS(count_missing, offsetof(fos_stream_count, missing) == 16);
HOLDS(counts_size, sizeof(fos_stream_counts) == 64);
HOLDS(counts_accel, offsetof(fos_stream_counts, accel) == 20);
HOLDS(counts_temperature, offsetof(fos_stream_counts, temperature) == 40);
HOLDS(counts_passed_over, offsetof(fos_stream_counts, passed_over) == 60);
HOLDS(flash_read, offsetof(fos_flash, read) == sizeof(void *));
HOLDS(flash_write, offsetof(fos_flash, write) == 2 * sizeof(void *));
HOLDS(flash_erase, offsetof(fos_flash, erase) == 3 * sizeof(void *));
HOLDS(flash_address, offsetof(fos_flash, address) == 4 * sizeof(void *));
HOLDS(flash_capacity, offsetof(fos_flash, capacity) == 4 * sizeof(void *) + 4);
HOLDS(flash_erase_size, offsetof(fos_flash, erase_size) == 4 * sizeof(void *) + 8);
HOLDS(flash_size, sizeof(fos_flash) == 4 * sizeof(void *) + (sizeof(void *) > 4 ? 16 : 12));
HOLDS(status_size, sizeof(fos_status) == 4);
