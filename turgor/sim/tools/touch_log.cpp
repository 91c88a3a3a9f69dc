#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

ForceSample sample_of(double time, const contact::ToolCommand& command, const contact::ToolReading& reading) {
  return {.time = time,
          .position = command.pose.position,
          .force = reading.force,
          .torque = reading.torque,
          .contacts = reading.contacts,
          .depth = reading.depth,
          .beyond_patch = reading.beyond_patch,
          .hold = command.hold,
          .grip = command.grip,
          .axes = command.pose.axes};
}

contact::ToolCommand command_of(const ForceSample& sample) {
  return {.pose = {sample.position, sample.axes}, .grip = sample.grip, .hold = sample.hold};
}

void TouchLog::preallocate(std::size_t most) {
  most_ = most;
  samples_.reserve(most);
}

void TouchLog::append(ForceSample sample) {
  if (samples_.size() >= most_) {
    missed_++;
    return;
  }
  if (!samples_.empty()) sample.path = back().path + norm(sample.position - back().position);
  samples_.push_back(sample);
}

}  // namespace turgor
