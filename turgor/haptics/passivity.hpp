// Time-domain passivity: an observer integrates the energy between hand and model, and a controller adds
// damping when more energy came out than went in. Hannaford and Ryu, "Time-domain passivity control of haptic
// interfaces", IEEE Transactions on Robotics and Automation 18 (2002).
//
// With f the force on the hand, constant from one tick to the next, and x the hand's position,
//
//   W[n] = W[n−1] − f[n−1]·(x[n] − x[n−1]) − τ[n−1]·θ        θ: rotation from one tick to the next
//
// is the energy taken from the hand and not returned. The product is exact for a constant force (Ryu, Kim,
// Hannaford 2004). f is the force really sent to the device, so the observer includes its controller. When W
// < 0 the controller adds −α v with α T |v|² = −W, as far as the device renders α. Translation and rotation
// share one energy, because a lever may return in one what it took in the other.
//
// Energy dissipated by rubbing for a minute would allow a wall to oscillate for a minute. So W never exceeds
// the energy that a body can return: f·reach, for a press with f no deeper than `reach`. Without a force it
// is zero.
#pragma once

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

struct PassivityParams {
  double damping = 10;            // largest that the device renders: see largest_damping [N·s/m]
  double angular_damping = 0.03;  // [N·m·s/rad]
  double reach = 0.05;            // largest depth of a press [m]
  double angular_reach = 0.5;     // largest rotation [rad]
  double debt = 0.05;             // largest deficit that is collected from a body that moves by itself [J]
  double rest = 0.2;              // time without force after which a deficit is forgiven [s]
};

struct Passivity {
  double energy = 0;         // W [J]
  double lowest = 0;         // minimum over time [J]
  DeviceOutput held_output;  // since the last tick
  contact::Pose before;
  double force_free_time = 0;  // [s]
  bool has_pose = false;
};

/// Largest damping that a device of mass `spec.mass` [kg] renders at period `dt` [s] without oscillating:
/// half the value that reverses its velocity within a tick (m/T), and no more than its maker states
/// (`spec.damping`, 0 = unknown) [N·s/m].
double largest_damping(const DeviceSpec& spec, double dt);

/// Integrates the energy of the tick that ended at the hand's present pose.
void observe(const PassivityParams& params, Passivity& state, const contact::Pose& pose, double dt);

/// Output with the damping that compensates a negative W. `damped` is true when damping was added.
DeviceOutput add_passivity_damping(const PassivityParams& params, const Passivity& state,
                                   const DeviceOutput& wanted, const DeviceInput& hand, double dt,
                                   bool& damped);

}  // namespace turgor::haptics
