#include "turgor/haptics/virtual_device.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

Vec3d rounded(Vec3d v, double step) {
  TURGOR_CHECK(step >= 0, "the resolution of an encoder is not negative");
  if (step == 0) return v;
  return {step * std::round(v.x / step), step * std::round(v.y / step), step * std::round(v.z / step)};
}

/// Dry friction over a time: reduces the speed by `change`, not below zero.
Vec3d slowed(Vec3d speed, double change) {
  TURGOR_CHECK(change >= 0, "friction only slows a motion");
  const double length = norm(speed);
  return length > change ? speed * (1 - change / length) : Vec3d{};
}

/// One substep of `motion` about the hand's target. `push` contains the forces that do not depend on the
/// motion.
void advance_motion(const ExactStep& s, Vec3d push, double friction_change, ArmMotion& motion) {
  const ArmMotion before = motion;
  motion.offset = before.offset * s.xx + before.speed * s.xv + push * s.xu;
  motion.speed = slowed(before.offset * s.vx + before.speed * s.vv + push * s.vu, friction_change);
}

}  // namespace

/// Matrix exponential of [[0 1 0] [−k/m −b/m 1/m] [0 0 0]]·t by scaling and squaring of a Taylor series.
ExactStep exact_step(double mass, double damping, double stiffness, double time) {
  TURGOR_CHECK(mass > 0 && time > 0, "a moving arm has mass, and a step has a positive length");
  constexpr int kSquarings = 4, kTerms = 12;
  const double t = time / (1 << kSquarings);
  using Affine = ExactStep;
  const auto times = [](const Affine& a, const Affine& b) {  // a after b
    return Affine{a.xx * b.xx + a.xv * b.vx, a.xx * b.xv + a.xv * b.vv, a.xx * b.xu + a.xv * b.vu + a.xu,
                  a.vx * b.xx + a.vv * b.vx, a.vx * b.xv + a.vv * b.vv, a.vx * b.xu + a.vv * b.vu + a.vu};
  };
  // Horner's scheme of 1 + A (1 + A/2 (1 + A/3 …)). The input's row is (0 0 1).
  Affine sum;
  for (int n = kTerms; n >= 1; n--) {
    const double h = t / n, kx = -stiffness / mass * h, kv = -damping / mass * h, ku = h / mass;
    sum = {1 + h * sum.vx,
           h * sum.vv,
           h * sum.vu,
           kx * sum.xx + kv * sum.vx,
           1 + kx * sum.xv + kv * sum.vv,
           kx * sum.xu + kv * sum.vu + ku};
  }
  // squaring
  for (int i = 0; i < kSquarings; i++) sum = times(sum, sum);
  return sum;
}

VirtualHand light_grip(std::function<HandTarget(double)> target) {
  return {.mass = 0.1,
          .inertia = 1e-4,
          .damping = 3,
          .angular_damping = 5e-3,
          .stiffness = 300,
          .angular_stiffness = 0.5,
          .target = std::move(target)};
}

std::function<HandTarget(double)> path_through(std::vector<TimedTarget> samples) {
  TURGOR_ASSERT(!samples.empty(), "a path has at least one target");
  return [samples = std::move(samples)](double time) {
    // constant before the first sample and after the last
    const auto next = std::upper_bound(samples.begin(), samples.end(), time,
                                       [](double t, const TimedTarget& sample) { return t < sample.time; });
    if (next == samples.begin()) return samples.front().target;
    HandTarget target = std::prev(next)->target;
    if (next == samples.end()) return target;
    // linear interpolation
    const contact::Pose &from = target.pose, &to = next->target.pose;
    TURGOR_CHECK(next->time > std::prev(next)->time, "the times of targets increase");
    const double fraction = (time - std::prev(next)->time) / (next->time - std::prev(next)->time);
    target.pose = {from.position + (to.position - from.position) * fraction,
                   rotation(rotation_vector(to.axes * transposed(from.axes)) * fraction) * from.axes};
    target.grip += (next->target.grip - target.grip) * fraction;
    return target;
  };
}

VirtualDevice::VirtualDevice(const VirtualArm& arm, VirtualHand hand, VirtualTime time)
    : arm_(arm), hand_(std::move(hand)), clock_(time), step_(1 / (arm.rate * arm.substeps)) {
  TURGOR_ASSERT(arm.mass > 0 && arm.inertia > 0 && arm.rate > 0 && arm.substeps > 0,
                "an arm has mass and a rate");
  TURGOR_ASSERT(arm.delay >= 0 && arm.delay <= kLongestDelay, "a delay is at most 64 ticks");
  TURGOR_ASSERT(arm.velocity_window >= 0 && arm.velocity_window <= kLongestWindow,
                "a velocity is taken over at most 64 ticks");
  TURGOR_CHECK(arm.workspace_low.x <= arm.workspace_high.x && arm.workspace_low.y <= arm.workspace_high.y &&
                   arm.workspace_low.z <= arm.workspace_high.z,
               "a workspace has its lower corner first");
  // exact steps of translation and rotation
  linear_ = exact_step(arm.mass + hand_.mass, arm.viscous + hand_.damping, hand_.stiffness, step_);
  angular_ = exact_step(arm.inertia + hand_.inertia, arm.angular_viscous + hand_.angular_damping,
                        hand_.angular_stiffness, step_);
  // capabilities
  spec_ = {.name = "virtual",
           .workspace_low = arm.workspace_low,
           .workspace_high = arm.workspace_high,
           .force = arm.force,
           .torque = arm.torque,
           .grip_force = arm.grip_force,
           .stiffness = 2 * arm.viscous * arm.rate,  // Colgate's bound
           .damping = 0.5 * arm.mass * arm.rate,
           .mass = arm.mass,
           .has_orientation = true,
           .has_grip = arm.grip_force > 0,
           .rate = arm.rate};
}

HandTarget VirtualDevice::target(double time) const {
  return hand_.target ? hand_.target(time) : HandTarget{};
}

Status VirtualDevice::open() {
  open_ = true;
  time_ = 0;
  exchanges_ = 0;
  stopped_ = 0;
  outputs_ = {};
  from_ = to_ = target(0);
  set_motion(from_.pose);
  began_ = clock_ == VirtualTime::kClock ? steady_seconds() : 0;
  return Done{};
}

void VirtualDevice::set_motion(const contact::Pose& pose, Vec3d velocity, Vec3d angular_velocity) {
  pose_ = pose;
  velocity_ = velocity;
  angular_velocity_ = angular_velocity;
  samples_.fill({pose, time_});
}

double VirtualDevice::kinetic_energy() const {
  return 0.5 * (arm_.mass + hand_.mass) * dot(velocity_, velocity_) +
         0.5 * (arm_.inertia + hand_.inertia) * dot(angular_velocity_, angular_velocity_);
}

bool VirtualDevice::exchange(const DeviceOutput& output, DeviceInput& input) noexcept {
  if (!open_) return false;
  const std::size_t slots = outputs_.size();
  const auto acting = [&](std::size_t exchange) -> const DeviceOutput& {
    return outputs_[(exchange + slots - std::size_t(arm_.delay)) % slots];
  };
  int steps = arm_.substeps;
  if (clock_ == VirtualTime::kClock) {  // the last output acts until now
    constexpr double kLongest = 0.1;    // of a pause [s]
    const double now = steady_seconds() - began_;
    steps = std::max(0, int(std::min(now - time_, kLongest) / step_));
    for (int i = 0; i < steps; i++) advance(acting(exchanges_));
    if (now - time_ > kLongest) time_ = now;
  }
  // delay line, then one period with the output that acts
  exchanges_++;
  outputs_[exchanges_ % slots] = within_limits(spec_, output);
  if (clock_ == VirtualTime::kTicks)
    for (int i = 0; i < steps; i++) advance(acting(exchanges_));
  read(input);
  return true;
}

void VirtualDevice::advance(const DeviceOutput& output) {
  from_ = to_;
  to_ = target(time_ + step_);
  move(output);
  turn(output);
  stop_at_walls();
  time_ += step_;
}

/// Translation about the target's position at the middle of the substep. The target's velocity acts through
/// the hand's damper.
void VirtualDevice::move(const DeviceOutput& output) {
  const Vec3d goal = (from_.pose.position + to_.pose.position) * 0.5;
  const Vec3d push = output.force + (to_.pose.position - from_.pose.position) * (hand_.damping / step_);
  ArmMotion motion{pose_.position - goal, velocity_};
  // dry friction holds
  const bool sticks = velocity_ == Vec3d{} && norm(push - motion.offset * hand_.stiffness) <= arm_.coulomb;
  if (sticks) return;
  advance_motion(linear_, push, arm_.coulomb * step_ / (arm_.mass + hand_.mass), motion);
  pose_.position = goal + motion.offset;
  velocity_ = motion.speed;
}

/// Rotation about the target's axes in the same manner. Exact for small rotations and for rotations about one
/// axis.
void VirtualDevice::turn(const DeviceOutput& output) {
  // at rest, without rounding
  const bool rests = output.torque == Vec3d{} && angular_velocity_ == Vec3d{} &&
                     from_.pose.axes == to_.pose.axes && pose_.axes == to_.pose.axes;
  if (rests) return;
  // rotation from the target at the middle of the substep
  const Vec3d sweep = rotation_vector(to_.pose.axes * transposed(from_.pose.axes));
  const Mat3d goal = rotation(sweep * 0.5) * from_.pose.axes;
  const Vec3d rotation_error = rotation_vector(pose_.axes * transposed(goal));
  const Vec3d push = output.torque + sweep * (hand_.angular_damping / step_);
  ArmMotion motion{rotation_error, angular_velocity_};
  // dry friction holds
  const bool sticks = angular_velocity_ == Vec3d{} &&
                      norm(push - rotation_error * hand_.angular_stiffness) <= arm_.angular_coulomb;
  if (sticks) return;
  advance_motion(angular_, push, arm_.angular_coulomb * step_ / (arm_.inertia + hand_.inertia), motion);
  pose_.axes = rotation(motion.offset - rotation_error) * pose_.axes;
  angular_velocity_ = motion.speed;
}

void VirtualDevice::stop_at_walls() {
  bool stops = false;
  for (int axis = 0; axis < 3; axis++) {
    double& x = pose_.position[axis];
    const double inside = std::clamp(x, arm_.workspace_low[axis], arm_.workspace_high[axis]);
    if (inside != x) velocity_[axis] = 0, stops = true;
    x = inside;
  }
  if (stops) stopped_ = stopped_ + step_;
}

std::string VirtualDevice::remarks() const {
  const double stopped = stopped_;
  return stopped > 0 ? fmt::format("the hand was at the end of the workspace for {:.3f} s", stopped)
                     : std::string();
}

void VirtualDevice::read(DeviceInput& input) {
  // encoder
  const contact::Pose seen{rounded(pose_.position, arm_.encoder),
                           rotation(rounded(rotation_vector(pose_.axes), arm_.angular_encoder))};
  // velocity from the encoder's difference over the window
  const std::size_t slots = samples_.size();
  const Sample& before = samples_[(exchanges_ + slots - std::size_t(arm_.velocity_window)) % slots];
  const double passed = time_ - before.time;
  input = {.pose = seen,
           .velocity = velocity_,
           .angular_velocity = angular_velocity_,
           .grip = to_.grip,
           .buttons = to_.buttons,
           .time = began_ + time_};
  if (arm_.velocity_window > 0 && passed > 0) {
    input.velocity = (seen.position - before.pose.position) / passed;
    input.angular_velocity = rotation_vector(seen.axes * transposed(before.pose.axes)) / passed;
  }
  samples_[exchanges_ % slots] = {seen, time_};
}

}  // namespace turgor::haptics
