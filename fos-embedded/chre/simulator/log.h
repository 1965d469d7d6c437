/*
 * What the sensors of the simulated phone measure: a log of `fos`, as CSV, row by row.
 */
#ifndef FOS_CHRE_SIMULATOR_LOG_H
#define FOS_CHRE_SIMULATOR_LOG_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fos {

struct Row {
    int64_t stamp_ns;
    float accel[3];      // m/s^2
    float gyro[3];       // rad/s
    float temperature_c; // NaN where the log has none
};

struct Log {
    std::vector<Row> rows;
    uint64_t period_ns; // nominal: that of the rate the sensor is set to
};

// The log in `path`, of a sensor that is set to `rate_hz`. Ends the program with a message where it is none.
Log read_log(const char *path, double rate_hz);

} // namespace fos

#endif
