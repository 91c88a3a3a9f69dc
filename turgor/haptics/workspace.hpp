// Where a device's workspace lies in the world, and how large. Newtons go one to one unless told otherwise:
// what the model answers is what the hand feels. A body is then felt `scale · force_scale` times as stiff,
// for a hand that moves 1 mm moves the tool by `scale` mm; stability is judged by that stiffness.
#pragma once

#include "turgor/contact/tool_io.hpp"
#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

struct Workspace {
  Vec3d origin;            // of the device's frame, in the world [m]
  Mat3d axes;              // of the device's frame in the world: its right, its away from the user, its up
  double scale = 1;        // metres of the world a metre of the device
  double force_scale = 1;  // newtons of the device a newton of the world
};

inline contact::Pose to_world(const Workspace& workspace, const contact::Pose& pose) {
  return {workspace.origin + workspace.axes * (pose.position * workspace.scale), workspace.axes * pose.axes};
}

/// What a reading feels like in the device's frame.
inline DeviceOutput to_device(const Workspace& workspace, const contact::ToolReading& reading) {
  const Mat3d back = transposed(workspace.axes);
  return {.force = back * reading.force * workspace.force_scale,
          .torque = back * reading.torque * workspace.force_scale,
          .grip_force = reading.squeeze * workspace.force_scale};
}

/// Buttons that mean something to the loop, as bits of DeviceInput::buttons.
struct Buttons {
  std::uint32_t hold = 1;    // carries what is touched
  std::uint32_t clutch = 2;  // while pressed the hand moves and the tool does not
};

/// Lets go of the tool while its button is pressed: the hand finds room again, as with a mouse that is
/// lifted.
struct Clutch {
  Vec3d offset;  // of the tool from where the workspace alone puts it [m]
  Vec3d stays;   // where the tool is while it is pressed [m]
  bool pressed = false;
};

/// Where the tool is, and whether it is held: for one tick, in the world.
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
