/*
 * The host of the simulated phone: takes what the nanoapp sends, and speaks to it when the script says so.
 */
#ifndef FOS_CHRE_SIMULATOR_HOST_H
#define FOS_CHRE_SIMULATOR_HOST_H

#include "script.h"

namespace fos {

// What arrives is written into this folder: bias.csv, telemetry (the stream), answers (a line each).
void open_host(const char *folder);

// Sends what a step of the script says; false if the step is not the host's.
bool host_takes(const Step &step);

// What came, in one line.
void close_host();

} // namespace fos

#endif
