// Checks of values from a device and to a device, shared by all drivers.
#pragma once

#include <chrono>
#include <cmath>

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// Time of the machine's steady clock, as in DeviceInput::time [s].
inline double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// True for plausible input: finite, a proper frame, within a meter of the center, below 20 m/s and 200
/// rad/s. Larger values are faults of a sensor or a connection.
inline bool is_plausible(const DeviceInput& input) {
  const auto shorter = [](Vec3d v, double limit) { return norm(v) < limit; };  // false for NaN
  return contact::is_valid(input.pose) && shorter(input.pose.position, 1) && shorter(input.velocity, 20) &&
         shorter(input.angular_velocity, 200) && std::isfinite(input.grip);
}

/// Output clamped to the device's limits; zero when a value is not finite.
inline DeviceOutput sendable_output(const DeviceSpec& spec, const DeviceOutput& output) {
  return is_finite(output) ? within_limits(spec, output) : DeviceOutput{};
}

}  // namespace turgor::haptics
