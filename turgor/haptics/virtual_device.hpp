// A simulated haptic device: an arm with mass, friction, encoder, workspace, force limit and delay, held by a
// hand modeled as mass, damper and spring to a target. Deterministic and free of noise. The force is constant
// from one exchange to the next, as with real devices. Between exchanges the linear motion is exact (a matrix
// exponential), so that any growing oscillation is not an artifact of the arm. It allows tests of the loop,
// the safety chain and the Z-width without hardware.
//
// Colgate and Brown, "Factors affecting the Z-width of a haptic display" (1994); Abbott and Okamura, "Effects
// of position quantization and sampling rate on virtual-wall passivity" (2005).
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <vector>

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

/// Parameters of an arm. The defaults are those of a desktop arm with 12 N.
struct VirtualArm {
  double mass = 0.15, inertia = 2e-4;              // [kg] [kg·m²]
  double viscous = 0.5, angular_viscous = 5e-4;    // friction [N·s/m] [N·m·s/rad]
  double coulomb = 0.05, angular_coulomb = 2e-4;   // dry friction [N] [N·m]
  double encoder = 10e-6, angular_encoder = 2e-4;  // resolution; 0: exact [m] [rad]
  int velocity_window = 1;                         // ticks over which positions are differenced; 0: exact
  Vec3d workspace_low{-0.08, -0.08, -0.08}, workspace_high{0.08, 0.08, 0.08};  // inelastic stops [m]
  double force = 12, torque = 0.4, grip_force = 0;                             // limits [N] [N·m] [N]
  int delay = 0;                                                               // ticks until a force acts
  double rate = 1000;                                                          // [Hz]
  int substeps = 8;                                                            // a tick
};

/// Target of a hand, with grip and buttons.
struct HandTarget {
  contact::Pose pose;
  double grip = 0;
  std::uint32_t buttons = 0;
};

/// Impedance of a hand. All zero: the arm is not held.
struct VirtualHand {
  double mass = 0, inertia = 0;                   // [kg] [kg·m²]
  double damping = 0, angular_damping = 0;        // [N·s/m] [N·m·s/rad]
  double stiffness = 0, angular_stiffness = 0;    // [N/m] [N·m/rad]
  std::function<HandTarget(double time)> target;  // time since open [s]; must not allocate
};
/// Impedance of a hand that holds a stylus lightly: 0.1 kg, 3 N·s/m, 300 N/m.
VirtualHand light_grip(std::function<HandTarget(double)> target);

/// Target at a time.
struct TimedTarget {
  double time = 0;  // [s]
  HandTarget target;
};
/// Linear interpolation of targets, constant before the first and after the last. Their times increase.
std::function<HandTarget(double)> path_through(std::vector<TimedTarget> samples);

/// Clock of a virtual device.
enum class VirtualTime : std::uint8_t {
  kTicks,  // one period an exchange, independent of real time: for tests and benches
  kClock,  // the machine's clock
};

/// State of translation or rotation.
struct ArmMotion {
  Vec3d offset, speed;  // [m] [m/s], or [rad] [rad/s]
};
/// Exact step of m x'' = −b x' − k x + u over a fixed time: x' = xx x + xv v + xu u, and v accordingly.
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
  std::string remarks() const override;

  /// Sets pose and velocity; for tests.
  void set_motion(const contact::Pose& pose, Vec3d velocity = {}, Vec3d angular_velocity = {});
  /// Moves arm and hand to a pose at once.
  void teleport(const contact::Pose& pose) { set_motion(pose), from_ = to_ = target(time_); }
  /// Exact pose, without the encoder's resolution.
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
  std::array<DeviceOutput, kLongestDelay + 1> outputs_{};
  std::array<Sample, kLongestWindow + 1> samples_{};
  std::size_t exchanges_ = 0;
  std::atomic<double> stopped_ = 0;  // time at the end of the workspace [s]
};

}  // namespace turgor::haptics
