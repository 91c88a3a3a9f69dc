#include "turgor/haptics/device.hpp"

#include <gtest/gtest.h>

namespace turgor::haptics {

// A force that exceeds the limit keeps its direction; axes without motors get zero.
TEST(Device, LimitedForceKeepsDirection) {
  const DeviceSpec spec{.force = 5};
  const DeviceOutput haptic =
      within_limits(spec, {.force = {30, -40, 0}, .torque = {1, 0, 0}, .grip_force = 3});
  EXPECT_NEAR(haptic.force.x, 3, 1e-12);
  EXPECT_NEAR(haptic.force.y, -4, 1e-12);
  EXPECT_EQ(norm(haptic.torque), 0);  // the device has no such axis
  EXPECT_EQ(haptic.grip_force, 0);
}

}  // namespace turgor::haptics
