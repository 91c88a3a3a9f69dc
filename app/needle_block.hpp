// A needle that moves along its axis in a block of one material, for `turgor validate surgery` and benches.
#pragma once

#include <functional>

#include "turgor/contact/needle_touch.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"

namespace turgor {

/// Block from the origin to `size`, and the part of it whose Green's functions are solved.
struct NeedleBlock {
  Vec3d size{0.06, 0.06, 0.06};  // [m]
  double edge = 0.01;            // of its elements [m]
  double young = 4e3, poisson = 0.45;
  bool is_quadratic = false;    // tetrahedra instead of hexahedra
  bool are_sides_held = false;  // instead of the bottom
  Vec3d axis;                   // only elements around the vertical line through it; zero = all [m]
};
Result<sfem::InnerGreen> inner_green_of(const Exec& exec, const NeedleBlock& block);

/// Needle on the line through `entry` along the z axis of `pose`.
struct NeedlePush {
  const sfem::InnerGreen& inner;
  contact::Needle needle;
  Vec3d entry;  // [m]
  contact::Pose pose;
  contact::NeedleState state;
};
/// Needle 1 mm above `entry`, tilted from the vertical toward a direction around it [rad].
NeedlePush needle_above(const sfem::InnerGreen& inner, const contact::Needle& needle, Vec3d entry,
                        double tilt, double around);
/// Moves the tip to a depth along the axis by about `step` a tick [m]. Calls visit(depth, force along the
/// axis) after every tick.
void push_to(NeedlePush& push, double depth, double step,
             const std::function<void(double, double)>& visit = {});
/// Difference of the accounted and the hand's work, relative to the latter.
double energy_error(const contact::NeedleWork& work);

}  // namespace turgor
