#include "turgor/haptics/workspace.hpp"

#include <gtest/gtest.h>

#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {
namespace {

/// Rotated about z by a quarter turn, scaled by two, with another origin.
Workspace turned() { return {.origin = {1, 2, 3}, .axes = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}, .scale = 2}; }

// The workspace rotates and scales the motion of the hand.
TEST(Workspace, HandMotionIsRotatedAndScaled) {
  const contact::Pose tool = to_world(turned(), {.position = {0.01, 0, 0}, .axes = {}});
  EXPECT_LT(norm(tool.position - Vec3d{1, 2.02, 3}), 1e-12);
  EXPECT_EQ(tool.axes.column[0], (Vec3d{0, 1, 0}));
}

// Forces are rotated to the device and scaled by the force scale only.
TEST(Workspace, ForceIsRotatedNotScaled) {
  const DeviceOutput haptic = to_device(turned(), {.force = {0, 3, 0}, .torque = {0.1, 0, 0}});
  EXPECT_LT(norm(haptic.force - Vec3d{3, 0, 0}), 1e-12);  // Force along the device's x axis.
  EXPECT_LT(norm(haptic.torque - Vec3d{0, -0.1, 0}), 1e-12);
  Workspace weak = turned();
  weak.force_scale = 0.5;
  EXPECT_LT(norm(to_device(weak, {.force = {0, 3, 0}}).force - Vec3d{1.5, 0, 0}), 1e-12);
}

// The pressed clutch holds the tool; after release it continues from its position.
TEST(Workspace, ClutchHoldsTool) {
  const Workspace workspace = turned();
  const Buttons buttons;
  Clutch clutch;
  const auto tool = [&](double x, std::uint32_t pressed) {
    DeviceInput hand;
    hand.pose.position.x = x;
    hand.buttons = pressed;
    return command(workspace, buttons, clutch, hand);
  };
  EXPECT_NEAR(tool(0.03, 0).pose.position.y, 2.06, 1e-12);
  EXPECT_NEAR(tool(0.03, buttons.clutch).pose.position.y, 2.06, 1e-12);
  EXPECT_NEAR(tool(-0.05, buttons.clutch).pose.position.y, 2.06, 1e-12);
  EXPECT_NEAR(tool(-0.05, 0).pose.position.y, 2.06, 1e-12);
  EXPECT_NEAR(tool(-0.04, 0).pose.position.y, 2.08, 1e-12);
  EXPECT_NEAR(tool(-0.04, buttons.clutch | buttons.hold).pose.position.y, 2.08, 1e-12);
  EXPECT_TRUE(tool(-0.04, buttons.hold).hold);
  EXPECT_FALSE(tool(-0.04, 0).hold);
}

}  // namespace
}  // namespace turgor::haptics
