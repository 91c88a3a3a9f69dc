// No energy out of nothing: an observer adds up what flows between the hand and what it feels, and a
// controller damps when more came out than went in. Hannaford and Ryu, "Time-domain passivity control of
// haptic interfaces", IEEE Transactions on Robotics and Automation 18 (2002).
//
// With f the force on the hand, held from one tick to the next, and x where the hand is,
//
//   W[n] = W[n−1] − f[n−1]·(x[n] − x[n−1]) − τ[n−1]·θ        θ: the turn from one tick to the next
//
// is the energy taken from the hand and not given back. That product is exact for a force that is held (Ryu,
// Kim, Hannaford 2004), and f is what the device was really given, so the observer sees its controller too.
// When W < 0 the controller adds −α v with α T |v|² = −W, as far as the device renders α. Motion and turning
// are one account: what a lever takes in one it may give in the other.
//
// The account of a hand that rubbed for a minute would let a wall ring for a minute. So W never exceeds what
// a body can give back: pressed with f no deeper than `reach`, that is f·reach. Where nothing is felt it is
// zero.
#pragma once

#include "turgor/haptics/device.hpp"

namespace turgor::haptics {

struct PassivityParams {
  double damping = 10;            // largest that the device renders: see largest_damping [N·s/m]
  double angular_damping = 0.03;  // [N·m·s/rad]
  double reach = 0.05;            // nothing is pressed deeper [m]
  double angular_reach = 0.5;     // or turned farther [rad]
  double debt = 0.05;             // a body that moves by itself may give; of that, no more is collected [J]
  double rest = 0.2;              // after so long without a force, what is owed is forgotten [s]
};

struct Passivity {
  double energy = 0;    // W [J]
  double lowest = 0;    // that it ever was [J]
  DeviceOutput haptic;  // since the last tick
  contact::Pose before;
  double rested = 0;  // without a force [s]
  bool began = false;
};

/// Largest damping that a device of `mass` [kg] at period `dt` [s] renders without shaking by itself: half of
/// what would turn its velocity around within a tick (m/T), and no more than its maker says (`spec.damping`,
/// 0 = not said) [N·s/m].
double largest_damping(const DeviceSpec& spec, double dt);

/// Adds up the tick that ended where the hand now is.
void observe(const PassivityParams& params, Passivity& state, const contact::Pose& pose, double dt);

/// What is to be felt, with the damping that pays what W lacks. True in `damped` when there was any.
DeviceOutput pay_back(const PassivityParams& params, const Passivity& state, const DeviceOutput& wanted,
                      const DeviceInput& hand, double dt, bool& damped);

}  // namespace turgor::haptics
