// What all drivers do with numbers that come from a device and go to it.
#pragma once

#include <chrono>
#include <cmath>

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// The machine's steady clock, that of DeviceInput::time [s].
inline double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Finite, a proper frame, and where and as fast as a hand can be: within a metre of the middle, below
/// 20 m/s and 200 rad/s. What is beyond is a fault of a sensor or a connection.
inline bool is_plausible(const DeviceInput& input) {
  const auto shorter = [](Vec3d v, double limit) { return norm(v) < limit; };  // false for what is no number
  return contact::is_valid(input.pose) && shorter(input.pose.position, 1) && shorter(input.velocity, 20) &&
         shorter(input.angular_velocity, 200) && std::isfinite(input.grip);
}

/// What may be sent: within the device's limits; nothing when a number of it is none.
inline DeviceOutput to_be_sent(const DeviceSpec& spec, const DeviceOutput& output) {
  return is_finite(output) ? within_limits(spec, output) : DeviceOutput{};
}

}  // namespace turgor::haptics
