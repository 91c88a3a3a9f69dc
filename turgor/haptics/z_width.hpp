// Z-width: the range of wall stiffness and damping that a hand can press without oscillation. A simulated
// hand presses a simulated arm (virtual_device.hpp) against a virtual wall; the trial is stable if it comes
// to rest. Colgate and Brown, "Factors affecting the Z-width of a haptic display" (1994). It uses no hardware
// and no clock, and gives the same bits everywhere.
#pragma once

#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {

/// Source of the force in a tick.
enum class WallAnswer : std::uint8_t {
  kTick,   // the wall itself
  kHeld,   // force of the last physics frame, without delay
  kLocal,  // contact of one whole frame ago: plane, stiffness, damping
};

struct WallTrial {
  VirtualArm arm;
  double hand_mass = 0.1, hand_damping = 1, hand_stiffness = 300;  // [kg] [N·s/m] [N/m]
  double stiffness = 1000, damping = 0;                            // of the wall [N/m] [N·s/m]
  WallAnswer answer = WallAnswer::kTick;
  double frame_rate = 1000;  // of physics [Hz]
  bool controller = true;    // passivity controller; the other safety links are always active
  double depth = 0.005;      // target of the hand behind the wall [m]
  double seconds = 2;
};

struct WallVerdict {
  bool stable = false;
  double early = 0, late = 0;  // mean kinetic energy after the press and at the end [J]
  double speed = 0;            // root mean square at the end [m/s]
  double lowest_energy = 0;    // smallest W [J]
  double largest_force = 0;    // [N]
};

/// Presses a wall. The result is stable at rest, or when the motion decays by itself.
WallVerdict press_wall(const WallTrial& trial);

/// Largest stiffness of a wall with damping B that creates no energy, with any hand, on an arm of viscous
/// friction b and period T: b > K T/2 + |B| (Colgate and Schenkel 1994, 1997). Not positive: no such wall
/// [N/m].
double colgate_stiffness(double arm_viscous, double wall_damping, double period);
/// Largest stiffness at which a hand comes to rest, with total damping `damping` of arm and hand: K < (b +
/// B)/(T/2 + delay) (Hulin, Preusche, Hirzinger 2006; Gil and others 2009). For soft hands, and for B well
/// below m/T [N/m].
double resting_stiffness(double damping, double wall_damping, double period, double delay = 0);
/// Largest stiffness at which dry friction dissipates the energy created by encoder steps: 2 f/Δ (Abbott and
/// Okamura 2005) [N/m].
double quantized_stiffness(double coulomb, double encoder);

}  // namespace turgor::haptics
