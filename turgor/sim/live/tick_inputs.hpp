// What each side of a felt body knew of the other. Between a haptic thread and the frames the newest value
// wins (core/latest.hpp), and which one that is depends on the clock; who writes it down can do a felt run
// again, tick by tick, without a clock (haptic_replay.hpp).
#pragma once

#include <cstdint>
#include <deque>

#include "turgor/core/latest.hpp"

namespace turgor {

/// Of what frames had left for it, what a tick answered from; both count from 1.
struct TickInputs {
  std::int32_t frame = 0, patch = 0;
};

/// Of the ticks, and of the patches that are built beside both, what a frame went by: how many there were.
struct FrameInputs {
  std::int32_t ticks = 0, patches = 0;
};

/// In a replay: what frames have left, until a tick comes that knew it. T counts itself by `number`.
template <class T>
struct Awaiting {
  std::deque<T> values;

  void keep(latest<T>& left) {
    if (left.has_news()) values.push_back(left.read());
  }
  void give(long number, latest<T>& left) {
    for (; !values.empty() && values.front().number <= number; values.pop_front()) left.write(values.front());
  }
};

}  // namespace turgor
