// Interface of a haptic device: an arm held by a hand. Pose and buttons are input, forces are output, each
// exchanged as a whole. This is the one virtual interface in Turgor, because the kind of a device is known at
// run time only.
#pragma once

#include <cstdint>
#include <string>

#include "turgor/contact/tool.hpp"
#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::haptics {

/// State of a device at one time. Its frame: right-handed, origin in the middle of its workspace, x to the
/// right, y away from the user, z up.
struct DeviceInput {
  contact::Pose pose;         // of the grip, whose y axis is that of its tip [m]
  Vec3d velocity;             // of its origin [m/s]
  Vec3d angular_velocity;     // [rad/s]
  double grip = 0;            // closing of its gripper: 0 open, 1 closed
  std::uint32_t buttons = 0;  // a bit each, the first one is bit 0
  double time = 0;            // of the reading, on the machine's steady clock [s]
};

/// Command to a device, valid until the next one.
struct DeviceOutput {
  Vec3d force, torque;    // on the hand, the torque about the grip's origin [N] [N·m]
  double grip_force = 0;  // opens the gripper [N]
};

/// Capabilities of a device. A limit of 0 means that the axis does not exist.
struct DeviceSpec {
  std::string name;
  Vec3d workspace_low, workspace_high;  // reach of the grip [m]
  double force = 0;                     // largest, in any direction [N]
  double torque = 0;                    // [N·m]
  double grip_force = 0;                // [N]
  double stiffness = 0;                 // largest that feels rigid [N/m]
  double damping = 0;                   // [N·s/m]
  double mass = 0;                      // at the grip; 0 = unknown [kg]
  bool has_orientation = false;         // false: the axes of every pose are those of the device's frame
  bool has_grip = false;
  double rate = 1000;  // design rate [Hz]
};

/// True when all values are finite.
bool is_finite(const DeviceOutput& output);
/// Output clamped to the device's limits, directions unchanged. Zero for axes that do not exist.
DeviceOutput within_limits(const DeviceSpec& spec, const DeviceOutput& output);

/// Timing source of the exchange.
enum class Pacing : std::uint8_t {
  kLoop,      // exchange returns at once; the loop keeps the time
  kDevice,    // exchange waits for the device's next tick
  kCallback,  // the device calls from its own thread: see Device::start
};

/// Callback for a tick of a device's own thread.
using DeviceTick = void (*)(void* context, const DeviceInput& input, DeviceOutput& output);

class Device {
 public:
  virtual ~Device() = default;

  /// Connects. Force stays zero until the first exchange. Error: what is missing, and what to install.
  virtual Status open() = 0;
  /// Valid once the device is open.
  virtual const DeviceSpec& spec() const = 0;
  virtual Pacing pacing() const { return Pacing::kLoop; }

  /// Sends the output and receives the input, both whole. Does not allocate. False when the device is lost or
  /// its data is implausible; `input` is unchanged then.
  virtual bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept = 0;

  /// For Pacing::kCallback only: calls `tick` in every tick until close.
  virtual Status start(DeviceTick /*tick*/, void* /*context*/) { return Done{}; }

  /// Sets force to zero, ends the thread and closes the connection. Safe at any time, more than once.
  virtual void close() noexcept = 0;

  /// Reason for the loss of the device, as a sentence; empty while it works. Not for the haptic thread.
  virtual std::string trouble() const { return {}; }
  /// Warnings during operation with their counts (warm motors, …); empty if none. Not for the haptic thread.
  virtual std::string remarks() const { return {}; }
};

}  // namespace turgor::haptics
