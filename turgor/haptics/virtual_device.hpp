// A haptic device that is computed: an arm with mass, friction, an encoder, a workspace, a force limit and a
// delay, held by a hand that is a mass, a damper and a spring to where it wants to be. Deterministic and free
// of noise. The force is held from one exchange to the next, as devices do; between them the motion is exact
// for everything linear (a matrix exponential), so what grows is never the arm's own doing. With it the loop,
// the safety chain and the Z-width need no hardware.
//
// Colgate and Brown, "Factors affecting the Z-width of a haptic display" (1994); Abbott and Okamura, "Effects
// of position quantization and sampling rate on virtual-wall passivity" (2005).
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// The defaults are those of a desktop arm with 12 N.
struct VirtualArm {
  double mass = 0.15, inertia = 2e-4;              // [kg] [kg·m²]
  double viscous = 0.5, angular_viscous = 5e-4;    // friction [N·s/m] [N·m·s/rad]
  double coulomb = 0.05, angular_coulomb = 2e-4;   // dry friction [N] [N·m]
  double encoder = 10e-6, angular_encoder = 2e-4;  // steps; 0: exact [m] [rad]
  int velocity_window = 1;                         // ticks over which places are differenced; 0: exact
  Vec3d workspace_low{-0.08, -0.08, -0.08}, workspace_high{0.08, 0.08, 0.08};  // ends without a bounce [m]
  double force = 12, torque = 0.4, grip_force = 0;                             // limits [N] [N·m] [N]
  int delay = 0;                                                               // ticks until a force acts
  double rate = 1000;                                                          // [Hz]
  int substeps = 8;                                                            // a tick
};

/// Where a hand wants to be, and what its fingers do.
struct HandTarget {
  contact::Pose pose;
  double grip = 0;
  std::uint32_t buttons = 0;
};

/// All zero: nobody holds the arm.
struct VirtualHand {
  double mass = 0, inertia = 0;                   // [kg] [kg·m²]
  double damping = 0, angular_damping = 0;        // [N·s/m] [N·m·s/rad]
  double stiffness = 0, angular_stiffness = 0;    // [N/m] [N·m/rad]
  std::function<HandTarget(double time)> target;  // time since open [s]; allocates nothing, by its writer
};
/// A hand that holds a stylus lightly: 0.1 kg, 3 N·s/m, 300 N/m.
VirtualHand light_hand(std::function<HandTarget(double)> target);

/// Where a hand wants to be at a time.
struct TimedTarget {
  double time = 0;  // [s]
  HandTarget target;
};
/// Straight from each to the next; before the first and after the last it stays. Their times increase.
std::function<HandTarget(double)> path_through(std::vector<TimedTarget> samples);

/// Whose time passes.
enum class VirtualTime : std::uint8_t {
  kTicks,  // a period an exchange, whatever the clock says: for tests and benches
  kClock,  // the machine's
};

/// What moves, of translation or of rotation.
struct ArmMotion {
  Vec3d place, speed;  // [m] [m/s], or [rad] [rad/s]
};
/// m x'' = −b x' − k x + u over a fixed time, exactly: x' = xx x + xv v + xu u, and v alike.
struct ExactStep {
  double xx = 1, xv = 0, xu = 0, vx = 0, vv = 1, vu = 0;
};
ExactStep exact_step(double mass, double damping, double stiffness, double time);

class VirtualDevice final : public Device {
 public:
  explicit VirtualDevice(const VirtualArm& arm, VirtualHand hand = {},
                         VirtualTime time = VirtualTime::kTicks);

  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override { open_ = false; }

  /// Sets it moving from somewhere; for tests.
  void place(const contact::Pose& pose, Vec3d velocity = {}, Vec3d angular_velocity = {});
  /// It is there now, with the hand that holds it.
  void put(const contact::Pose& pose) { place(pose), from_ = to_ = target(time_); }
  /// As it is, not as its encoder says.
  const contact::Pose& pose() const { return pose_; }
  Vec3d velocity() const { return velocity_; }
  Vec3d angular_velocity() const { return angular_velocity_; }
  double kinetic_energy() const;         // of arm and hand [J]
  double time() const { return time_; }  // since open [s]

 private:
  static constexpr int kLongestDelay = 64, kLongestWindow = 64;
  struct Sample {
    contact::Pose pose;
    double time = 0;
  };

  void advance(const DeviceOutput& output);
  void move(const DeviceOutput& output);
  void turn(const DeviceOutput& output);
  void stop_at_walls();
  void read(DeviceInput& input);
  HandTarget target(double time) const;

  VirtualArm arm_;
  VirtualHand hand_;
  VirtualTime clock_;
  DeviceSpec spec_;
  double step_;  // [s]
  ExactStep linear_, angular_;

  bool open_ = false;
  double time_ = 0, began_ = 0;  // [s]
  contact::Pose pose_;
  Vec3d velocity_, angular_velocity_;
  HandTarget from_, to_;  // of the substep
  std::array<DeviceOutput, kLongestDelay + 1> given_{};
  std::array<Sample, kLongestWindow + 1> read_{};
  std::size_t exchanges_ = 0;
};

}  // namespace turgor::haptics
