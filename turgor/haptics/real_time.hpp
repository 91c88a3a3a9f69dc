// A thread that is to wake up in time: its priority, memory that stays, sleep until a moment.
#pragma once

#include <string>

namespace turgor::haptics {

/// Now, on the clock that `sleep_until` means [s].
double steady_seconds();
/// Until then or at once.
void sleep_until(double seconds);

/// Of the calling thread: first in, first out before everybody else, and no slack in its timers. Empty, or
/// why not.
std::string take_priority(int priority);
/// Of the calling thread: what a tick may need of its stack is there.
void touch_stack();
/// What the process has in memory stays there. Empty, or why not.
std::string lock_memory();
void unlock_memory();

}  // namespace turgor::haptics
