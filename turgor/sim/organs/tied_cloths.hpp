// Cloths that attachments tie to each other. They step together. The force f of a spring acts on a vertex of
// one cloth and, reversed, on a point of the other one, whose position y follows the force:
//
//   f = −k (x − y(f)),     y(f) ≈ y(f₀) + S (f − f₀)
//
// Around a force f₀ with the position y(f₀), the first cloth is therefore tied to the target y(f₀) + S f₀
// with the stiffness k/(1 + k S), in an implicit step. The other cloth steps under −f. Both steps are
// repeated from the same state until the forces stay, with Anderson's mixing of the targets. S is a bound of
// the compliance of the other cloth in a step, so that forces do not alternate: that of its vertices without
// the fabric.
#pragma once

#include <vector>

#include "turgor/sim/bodies/cloth/cloth_body.hpp"

namespace turgor {

/// Step of a cloth in a frame.
struct ClothStep {
  ClothBody& body;
  cloth::Inputs inputs;
  std::vector<Vec3> v_before = {};  // velocities of held vertices before the step, by hold [m/s]
  cloth::StepReport report = {};
  double seconds = 0;  // wall time of the step
};

/// Cloths that step together with this one, itself included, in the order of their steps: where it exists,
/// the one in which the cloth whose vertices are tied comes before the other one.
std::vector<int> cloths_stepped_with(const World& world, int cloth);

/// Steps these cloths, and sets the forces of the attachments between them.
void step_tied_cloths(const Exec& exec, World& world, std::vector<ClothStep>& steps);

}  // namespace turgor
