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

void TouchLog::preallocate(std::size_t most, std::size_t in_memory) {
  samples_.limit_memory(most, in_memory);
}

void TouchLog::append(ForceSample sample) {
  if (!samples_.empty()) sample.path = back().path + norm(sample.position - back().position);
  samples_.append(sample);
}

}  // namespace turgor
