// Real-time settings of a thread: priority, locked memory, sleep until a deadline.
#pragma once

#include <string>

namespace turgor::haptics {

/// Present time on the clock of `sleep_until` [s].
double steady_seconds();
/// Sleeps until that time; returns at once if it has passed.
void sleep_until(double seconds);

/// Gives the calling thread first-in-first-out scheduling and no timer slack. Returns an empty text, or the
/// reason of refusal.
std::string set_real_time_priority(int priority);
/// Maps the stack pages that a tick may need, for the calling thread.
void prefault_stack();
/// Locks the process's memory. Returns an empty text, or the reason of refusal.
std::string lock_memory();
void unlock_memory();

}  // namespace turgor::haptics
