// Numbers of the data that ticks and frames of a body take from each other. Data pass through latest<>
// (core/latest.hpp), so wall-clock timing decides which value is used. A record of these numbers makes a
// haptic run reproducible without a clock (haptic_replay.hpp).
#pragma once

#include <cstdint>
#include <deque>

#include "turgor/core/latest.hpp"

namespace turgor {

/// Numbers of the frame and of the patch whose data a tick used, counted from 1, and the tick for whose
/// forces the patch was solved.
struct TickInputs {
  std::int32_t frame = 0, patch = 0;
  std::int32_t solution = -1;  // 0: as it was built; -1: frames solve it, or it is linear
};

/// Number of ticks done and of patches built when a frame began.
struct FrameInputs {
  std::int32_t ticks = 0, patches = 0;
};

/// Replay: queue of frame outputs. release() passes on the outputs up to the one that the recorded tick used.
/// T::number numbers the outputs.
template <class T>
struct ReplayQueue {
  std::deque<T> values;

  void push(latest<T>& output) {
    if (output.has_news()) values.push_back(output.read());
  }
  void release(long number, latest<T>& output) {
    for (; !values.empty() && values.front().number <= number; values.pop_front())
      output.write(values.front());
  }
};

}  // namespace turgor
