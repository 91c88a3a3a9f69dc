// A haptic device: an arm that a hand holds. Where the hand is goes in, what it is to feel goes out, each as
// a whole. Drivers are the one place in Turgor where the kind of a thing is known at run time only, so this
// is its one virtual interface.
#pragma once

#include <cstdint>
#include <string>

#include "turgor/contact/tool.hpp"
#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::haptics {

/// What a device says at one moment. Its frame: right-handed, origin in the middle of its workspace, x to the
/// right, y away from the user, z up.
struct DeviceInput {
  contact::Pose pose;         // of the grip [m]
  Vec3d velocity;             // of its origin [m/s]
  Vec3d angular_velocity;     // [rad/s]
  double grip = 0;            // how far its gripper is closed: 0 open, 1 closed
  std::uint32_t buttons = 0;  // a bit each, the first one is bit 0
  double time = 0;            // when this was read, on the machine's steady clock [s]
};

/// What a device is to do until it hears again.
struct DeviceOutput {
  Vec3d force, torque;    // on the hand, the torque about the grip's origin [N] [N·m]
  double grip_force = 0;  // that opens the gripper [N]
};

/// What a device can do. A limit of 0 means: it has no such axis.
struct DeviceSpec {
  std::string name;
  Vec3d workspace_low, workspace_high;  // that the grip can reach [m]
  double force = 0;                     // largest, any direction [N]
  double torque = 0;                    // [N·m]
  double grip_force = 0;                // [N]
  double stiffness = 0;                 // largest that feels firm [N/m]
  double damping = 0;                   // [N·s/m]
  double mass = 0;                      // at the grip; 0 = not known [kg]
  bool has_orientation = false, has_grip = false;
  double rate = 1000;  // that it is made for [Hz]
};

/// Every number of it is one.
bool is_finite(const DeviceOutput& output);
/// The same directions, no longer than the device bears; zero for axes that it has not.
DeviceOutput within_limits(const DeviceSpec& spec, const DeviceOutput& output);

/// Who calls whom.
enum class Pacing : std::uint8_t {
  kLoop,      // exchange returns at once: the loop keeps the time
  kDevice,    // exchange waits for the device's next tick
  kCallback,  // a thread of the device's own calls: see Device::start
};

/// What happens in a tick of a device's own thread.
using DeviceTick = void (*)(void* context, const DeviceInput& input, DeviceOutput& output);

class Device {
 public:
  virtual ~Device() = default;

  /// Connects; force stays zero until the first exchange. Error: what is missing, and what to install.
  virtual Status open() = 0;
  /// Valid once it is open.
  virtual const DeviceSpec& spec() const = 0;
  virtual Pacing pacing() const { return Pacing::kLoop; }

  /// Hands over what is to be felt and takes what the hand does, both whole. Does not allocate. False: the
  /// device is lost or what it said is not to be used; `input` is as it was.
  virtual bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept = 0;

  /// Pacing::kCallback alone: calls `tick` in every tick until close.
  virtual Status start(DeviceTick /*tick*/, void* /*context*/) { return Done{}; }

  /// Force zero, thread ended, connection closed. Safe at any time, more than once.
  virtual void close() noexcept = 0;

  /// Why it is lost, in a sentence; empty while it is not. Not for the haptic thread.
  virtual std::string trouble() const { return {}; }
  /// What it warned of while it worked, counted (warm motors, …); empty when of nothing. Not for that thread
  /// either.
  virtual std::string remarks() const { return {}; }
};

}  // namespace turgor::haptics
