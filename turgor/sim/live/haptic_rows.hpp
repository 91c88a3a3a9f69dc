// A haptic tick as a row of numbers, in recordings and logs.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/sim/live/haptic_recording.hpp"

namespace turgor {

/// Numbers of a tick: time, step, position, three axes, grip, hold.
constexpr std::size_t kHapticNumbers = 16;

inline void append_row(const HapticTick& tick, std::vector<double>& rows) {
  const contact::Pose& pose = tick.command.pose;
  rows.insert(rows.end(), {tick.time, tick.step});
  for (const Vec3d v : {pose.position, pose.axes.column[0], pose.axes.column[1], pose.axes.column[2]})
    rows.insert(rows.end(), {v.x, v.y, v.z});
  rows.insert(rows.end(), {tick.command.grip, double(tick.command.hold)});
  TURGOR_CHECK(rows.size() % kHapticNumbers == 0, "every tick has kHapticNumbers numbers");
}

inline HapticTick tick_of_row(std::span<const double> row) {
  TURGOR_CHECK(row.size() == kHapticNumbers, "every tick has kHapticNumbers numbers");
  const auto vector = [&row](std::size_t at) { return Vec3d{row[at], row[at + 1], row[at + 2]}; };
  return {.time = row[0],
          .step = row[1],
          .command = {.pose = {vector(2), {{vector(5), vector(8), vector(11)}}},
                      .grip = row[14],
                      .hold = row[15] != 0},
          .inputs_used = {}};
}

inline bool is_sound(const HapticTick& tick) {
  return std::isfinite(tick.time) && tick.step > 0 && tick.step <= 1 && tick.command.grip >= 0 &&
         tick.command.grip <= 1;
}

}  // namespace turgor
