// A session that a test looks on.
#pragma once

#include <functional>
#include <thread>

#include "turgor/core/timing.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor::test {

constexpr SessionParams kOneThread{
    .threads = 1, .loop = {.priority = 0, .lock_memory = false}, .longest = 60};

/// Whether it was so within `longest` [s].
inline bool wait_until(Session& session, const std::function<bool(const SessionNow&)>& is_so,
                       double longest = 20) {
  for (const Timer timer; timer.seconds() < longest;
       std::this_thread::sleep_for(std::chrono::milliseconds(2)))
    if (is_so(session.now())) return true;
  return false;
}

}  // namespace turgor::test
