/*
 * What happens to the simulated phone, and when: a text of lines `SECOND WHAT WORD…`, `#` before a comment.
 *
 *     0   missing SENSOR            there is no such sensor (accel, gyro, accel_temperature, gyro_temperature)
 *     T   rate SENSOR N             the hub reads it at every N-th row of the log from now on, and says so
 *     T   lose SENSOR SECONDS       nothing comes of this sensor for so long
 *     T   order WORD                batches arrive reversed: in threes, the last first; swapped: of gyro and
 *                                   accelerometer the later one first; or proper
 *     T   flood on|off              batches come without waiting for those before
 *     T   spoil on|off              some values are NaN, infinite, or far too large
 *     T   empty on|off              events without a reading come between the others
 *     T   host busy|free            the host takes no message
 *     T   restart                   the nanoapp is ended and started again
 *     T   model FILE [BYTES]        the host sends this image, in parts of so many bytes
 *     T   status                    the host asks for the status
 *     T   telemetry on|off          the host asks for telemetry
 *     T   motion detect|moving|still   the host says whether the phone moves
 *     T   message TYPE FILE         the host sends these bytes, whatever they are
 *
 * Seconds count from the first row of the log. What stands at one second happens in the order of the lines.
 */
#ifndef FOS_CHRE_SIMULATOR_SCRIPT_H
#define FOS_CHRE_SIMULATOR_SCRIPT_H

#include <cstdint>
#include <string>
#include <vector>

namespace fos {

struct Step {
    int64_t after_ns; // the first row
    std::string what;
    std::vector<std::string> words;
};

// The steps of the script in `path`, in the order of time. Ends the program with a message where a line is none.
std::vector<Step> read_script(const char *path);

} // namespace fos

#endif
