// A session that a test observes.
#pragma once

#include <functional>
#include <thread>

#include "turgor/core/timing.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor::test {

constexpr SessionParams kOneThread{
    .threads = 1, .loop = {.priority = 0, .lock_memory = false}, .longest = 60};

/// Polls the session until the condition holds; false after `longest` [s].
inline bool wait_until(Session& session, const std::function<bool(const SessionStatus&)>& condition,
                       double longest = 20) {
  for (const Timer timer; timer.seconds() < longest;
       std::this_thread::sleep_for(std::chrono::milliseconds(2)))
    if (condition(session.now())) return true;
  return false;
}

}  // namespace turgor::test
