// Needles that move along their axes in a lattice block of one material, for `turgor validate surgery` and
// tests.
#pragma once

#include <functional>
#include <vector>

#include "turgor/contact/lattice_needle.hpp"
#include "turgor/core/exec.hpp"

namespace turgor {

/// Block of solid tissue without skin, from the origin, that is fixed at its bottom or at its sides.
struct LatticeNeedleBlock {
  Int3 nodes{15, 15, 11};
  double spacing = 0.004, young = 1e4, poisson = 0.45;  // [m] [Pa]
  bool are_sides_fixed = false;
  int sweeps = 10;
};
struct LatticeUnderNeedles {
  lattice::Model model;
  lattice::State state;
  lattice::BodySurface surface;
};
LatticeUnderNeedles build_block(const LatticeNeedleBlock& block);
/// Height of its skin [m].
double top_of(const LatticeUnderNeedles& body);

/// Needle on a line through a point of the surface.
struct LatticeNeedlePush {
  contact::Needle needle;
  Vec3d entry;  // [m]
  contact::Pose pose;
  contact::LatticeNeedle state;
};
/// Needle 2 mm above `entry`, tilted from the vertical toward a direction around it [rad].
LatticeNeedlePush needle_above(const contact::Needle& needle, Vec3d entry, double tilt, double around);
double depth_of(const LatticeNeedlePush& push);  // along the needle [m]
double force_on(const LatticeNeedlePush& push);  // along the needle, against a push [N]

/// One step of 1/60 s with all needles at their poses.
void step_needles(const Exec& exec, LatticeUnderNeedles& body, std::vector<LatticeNeedlePush>& needles);
/// Moves all tips to a depth by about `step` a frame [m]. Calls visit() after every frame.
void push_to(const Exec& exec, LatticeUnderNeedles& body, std::vector<LatticeNeedlePush>& needles,
             double depth, double step, const std::function<void()>& visit = {});

}  // namespace turgor
