// Log of a tool, tick by tick: whole commands and readings, so that the hand motion can be replayed
// (hand.hpp). A full log only counts further samples.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/contact/tool_io.hpp"

namespace turgor {

constexpr double kTick = 1e-3;                            // of the haptic loop [s]
constexpr std::size_t kMostTicks = std::size_t(1) << 22;  // limit of a log: 70 minutes

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
};
ForceSample sample_of(double time, const contact::ToolCommand& command, const contact::ToolReading& reading);
contact::ToolCommand command_of(const ForceSample& sample);

class TouchLog {
 public:
  /// Pose before the first tick.
  void start(const contact::ToolCommand& command) { start_ = sample_of(0, command, {}); }
  const ForceSample& start() const { return start_; }

  /// Reserves memory for `most` samples, the new limit, so that append does not allocate on the haptic
  /// thread.
  void preallocate(std::size_t most);
  /// Sets ForceSample::path. A full log only counts the sample.
  void append(ForceSample sample);
  std::size_t missed() const { return missed_; }

  auto begin() const { return samples_.begin(); }
  auto end() const { return samples_.end(); }
  std::size_t size() const { return samples_.size(); }
  bool empty() const { return samples_.empty(); }
  const ForceSample& operator[](std::size_t i) const { return samples_[i]; }
  const ForceSample& back() const { return samples_.back(); }

 private:
  ForceSample start_;
  std::vector<ForceSample> samples_;
  std::size_t most_ = kMostTicks, missed_ = 0;
};

}  // namespace turgor
