/*
 * The sensors of the simulated phone, played from a log as fast as the events are taken.
 */
#ifndef FOS_CHRE_SIMULATOR_PLAYER_H
#define FOS_CHRE_SIMULATOR_PLAYER_H

#include "log.h"
#include "script.h"

namespace fos {

// Before CHRE starts: what is played, and what happens meanwhile. A step that is neither the player's nor the host's
// goes to `other`, which is called in the player's thread.
void open_player(const Log &log, const std::vector<Step> &steps, void (*other)(const Step &step));

// When the event loop runs: plays in a thread of its own; `ended` is called in it when the log is over.
void start_player(void (*ended)());

// Waits for that thread.
void close_player();

} // namespace fos

#endif
