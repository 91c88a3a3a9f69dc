#include "turgor/haptics/device.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace {

Vec3d no_longer_than(double limit, Vec3d v) {
  TURGOR_CHECK(limit >= 0, "the limit of a force is not negative");
  const double length = norm(v);
  return length > limit ? v * (limit / length) : v;
}

}  // namespace

bool is_finite(const DeviceOutput& output) {
  return is_finite(output.force) && is_finite(output.torque) && std::isfinite(output.grip_force);
}

DeviceOutput within_limits(const DeviceSpec& spec, const DeviceOutput& output) {
  TURGOR_CHECK(spec.grip_force >= 0, "the limit of a grip force is not negative");
  return {.force = no_longer_than(spec.force, output.force),
          .torque = no_longer_than(spec.torque, output.torque),
          .grip_force = std::clamp(output.grip_force, -spec.grip_force, spec.grip_force)};
}

}  // namespace turgor::haptics
