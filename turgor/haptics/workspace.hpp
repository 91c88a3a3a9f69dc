// Mapping of a device's workspace to the world. By default forces are mapped one to one. The rendered
// stiffness of a body is `scale · force_scale` times its own, because 1 mm of the hand moves the tool by
// `scale` mm. Stability is determined by that stiffness.
#pragma once

#include "turgor/contact/tool_io.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

struct Workspace {
  Vec3d origin;            // of the device's frame, in the world [m]
  Mat3d axes;              // of the device's frame in the world: right, away from the user, up
  Mat3d tool_axes;         // axes of the tool in the grip's frame: see kToolInGrip
  double scale = 1;        // meters of the world a meter of the device
  double force_scale = 1;  // newtons of the device a newton of the world
};

/// Axes of a tool in the grip's frame, of a tool that points where the grip points. A grip points along its y
/// axis. A tool points along its −z axis: the shaft of a needle lies along +z.
inline constexpr Mat3d kToolInGrip{{Vec3d{1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{0, -1, 0}}};

/// Pose of the tool in the world, for the pose of a grip.
inline contact::Pose to_world(const Workspace& workspace, const contact::Pose& pose) {
  TURGOR_CHECK(workspace.scale > 0, "the scale of a workspace is positive");
  return {workspace.origin + workspace.axes * (pose.position * workspace.scale),
          workspace.axes * (pose.axes * workspace.tool_axes)};
}

/// Output to the device for a reading, in the device's frame.
inline DeviceOutput to_device(const Workspace& workspace, const contact::ToolReading& reading) {
  const Mat3d back = transposed(workspace.axes);
  return {.force = back * reading.force * workspace.force_scale,
          .torque = back * reading.torque * workspace.force_scale,
          .grip_force = reading.squeeze * workspace.force_scale};
}

/// Button assignments of the loop, as bits of DeviceInput::buttons.
struct Buttons {
  std::uint32_t hold = 1;    // carry the touched tissue
  std::uint32_t clutch = 2;  // while pressed, the hand moves without the tool
};

/// Clutch: releases the tool while its button is pressed, so that the hand can be repositioned, as with a
/// lifted mouse.
struct Clutch {
  Vec3d offset;  // of the tool from its position by the workspace alone [m]
  Vec3d stays;   // position of the tool while pressed [m]
  bool pressed = false;
};

/// Command for the tool in one tick, in the world frame.
inline contact::ToolCommand command(const Workspace& workspace, const Buttons& buttons, Clutch& clutch,
                                    const DeviceInput& hand) {
  contact::ToolCommand out{
      .pose = to_world(workspace, hand.pose), .grip = hand.grip, .hold = (hand.buttons & buttons.hold) != 0};
  const bool pressed = (hand.buttons & buttons.clutch) != 0;
  if (pressed && !clutch.pressed) clutch.stays = out.pose.position + clutch.offset;
  clutch.pressed = pressed;
  if (pressed) clutch.offset = clutch.stays - out.pose.position;
  out.pose.position += clutch.offset;
  return out;
}

}  // namespace turgor::haptics
