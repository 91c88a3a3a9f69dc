// Log of a tool, tick by tick: whole commands and readings, so that the hand motion can be replayed
// (hand.hpp). A live log keeps its newest samples in memory and the others on disk (core/disk_log.hpp).
#pragma once

#include <cstddef>

#include "turgor/contact/needle_reading.hpp"
#include "turgor/contact/tool_io.hpp"
#include "turgor/core/disk_log.hpp"

namespace turgor {

constexpr double kTick = 1e-3;                                // of the haptic loop [s]
constexpr std::size_t kMostTicks = std::size_t(1) << 22;      // limit of a log: 70 minutes
constexpr std::size_t kTicksInMemory = std::size_t(1) << 16;  // of a live log: a minute

/// One tick of one tool.
struct ForceSample {
  double time = 0;            // [s]
  Vec3d position;             // of the tool's origin [m]
  Vec3d force, torque;        // on the tool, the torque about its origin [N] [N·m]
  int contacts = 0;           // contact sites with force
  double depth = 0;           // of the tool's deepest point below the surface at rest [m]
  double path = 0;            // length of the tool's path so far [m]
  float tick_seconds = 0;     // wall time of the tick, all tools of its body together
  bool new_patch = false;     // the patch was rebuilt before this tick
  bool beyond_patch = false;  // the tool reaches beyond the patch
  bool hold = false;          // rest of the command: see contact::ToolCommand
  double grip = 0;
  Mat3d axes;
  contact::NeedleReading needle = {};  // of a needle
};
ForceSample sample_of(double time, const contact::ToolCommand& command, const contact::ToolReading& reading);
contact::ToolCommand command_of(const ForceSample& sample);

class TouchLog {
 public:
  TouchLog() { samples_.limit(kMostTicks); }
  /// Pose before the first tick.
  void start(const contact::ToolCommand& command) { start_ = sample_of(0, command, {}); }
  const ForceSample& start() const { return start_; }

  /// Prepares for `most` samples, the new limit, with at most `in_memory` of them in memory. Append then does
  /// not allocate on the haptic thread.
  void preallocate(std::size_t most, std::size_t in_memory = kTicksInMemory);
  /// Sets ForceSample::path. A full log only counts the sample.
  void append(ForceSample sample);
  /// Moves older samples to disk; frame thread.
  void save() { samples_.save(); }
  std::size_t missed() const { return samples_.missed(); }

  auto begin() const { return samples_.begin(); }
  auto end() const { return samples_.end(); }
  std::size_t size() const { return samples_.size(); }
  bool empty() const { return samples_.empty(); }
  const ForceSample& operator[](std::size_t i) const { return samples_[i]; }
  const ForceSample& back() const { return samples_.back(); }

 private:
  ForceSample start_;
  DiskLog<ForceSample> samples_;
};

}  // namespace turgor
