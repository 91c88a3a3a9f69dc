// A session that a test observes, and a world that it steps.
#pragma once

#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "turgor/core/timing.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor::test {

constexpr SessionParams kOneThread{
    .threads = 1, .loop = {.priority = 0, .lock_memory = false}, .longest = 60};

/// Polls the session until the condition holds; false after `longest` [s].
inline bool wait_until(Session& session, const std::function<bool(const SessionStatus&)>& condition,
                       double longest = 120) {
  for (const Timer timer; timer.seconds() < longest;
       std::this_thread::sleep_for(std::chrono::milliseconds(2)))
    if (condition(session.now())) return true;
  return false;
}

/// Steps a world; a failed step fails the test.
inline void step_frames(World& world, int frames, const Exec& exec = Exec(1)) {
  for (int n = 0; n < frames; n++) {
    const Result<FrameReport> report = step(exec, world);
    ASSERT_TRUE(report) << report.error().message;
  }
}

}  // namespace turgor::test
