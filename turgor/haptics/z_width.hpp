// How stiff and how damped a wall a hand can press before the loop makes it shake: a hand presses a computed
// arm (virtual_device.hpp) against a virtual wall, and whether it comes to rest is the verdict. Over
// stiffness and damping that is the Z-width: Colgate and Brown, "Factors affecting the Z-width of a haptic
// display" (1994). No hardware, no clock, the same bits everywhere.
#pragma once

#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {

/// What answers a tick.
enum class WallAnswer : std::uint8_t {
  kTick,   // the wall itself
  kHeld,   // the force that physics found at the last frame, as if a frame took no time
  kLocal,  // what physics knew of the contact one whole frame ago: plane, stiffness, damping
};

struct WallTrial {
  VirtualArm arm;
  double hand_mass = 0.1, hand_damping = 1, hand_stiffness = 300;  // [kg] [N·s/m] [N/m]
  double stiffness = 1000, damping = 0;                            // of the wall [N/m] [N·s/m]
  WallAnswer answer = WallAnswer::kTick;
  double frame_rate = 1000;  // of physics [Hz]
  bool controller = true;    // of passivity; the other links of the safety chain are there in any case
  double depth = 0.005;      // that the hand wants to be behind the wall [m]
  double seconds = 2;
};

struct WallVerdict {
  bool stable = false;
  double early = 0, late = 0;  // mean kinetic energy after the press, and at the end [J]
  double speed = 0;            // root mean square at the end [m/s]
  double lowest_energy = 0;    // smallest W [J]
  double largest_force = 0;    // [N]
};

/// Rest, or motion that dies away by itself, is stable.
WallVerdict press_wall(const WallTrial& trial);

/// Largest stiffness of a wall of damping B that creates no energy at an arm of viscous friction b and period
/// T, whoever holds it: b > K T/2 + |B| (Colgate and Schenkel 1994, 1997). Not positive: none [N/m].
double colgate_stiffness(double arm_viscous, double wall_damping, double period);
/// Largest stiffness at which a hand comes to rest, when arm and hand together damp with `damping`:
/// K < (b + B)/(T/2 + delay) (Hulin, Preusche, Hirzinger 2006; Gil and others 2009). For soft hands, and for
/// B well below m/T [N/m].
double resting_stiffness(double damping, double wall_damping, double period, double delay = 0);
/// Largest stiffness at which dry friction eats what the encoder's steps put in: 2 f/Δ (Abbott and Okamura
/// 2005) [N/m].
double quantized_stiffness(double coulomb, double encoder);

}  // namespace turgor::haptics
