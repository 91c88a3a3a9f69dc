// The force of all cloth on one body. Cloth and body move by turns, frame by frame: the cloth is stopped by
// where the body went, and the body feels in the next frame what that took. A body without inertia would
// answer a cloth that lies on it by swinging higher each frame where the cloth makes it sink by more than
// g h²/4; so a body takes over a part of what changed, the smaller the softer it is (docs/models/cloth.md).
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/viscosity.hpp"

namespace turgor {

struct ClothLoad {
  std::vector<contact::VertexForce> force;  // that the body feels, ascending by vertex (a lattice's by slot)
  double part = 0.1;  // of a change of the force that it takes over in a frame [1]; nothing known = little
  Vec3d answer;       // how far such forces along x, y and z move the body at most, by their sum [m/N]
  int axis = 0;       // whose answer is looked at next
};

/// What all cloth did to a body in a frame.
struct ClothPush {
  std::vector<contact::VertexForce> force;  // on its vertices, in any order
  double mass = 0;                          // of the cloths that touch it [kg]
};

/// Takes over a part of what changed.
void take_over(const ClothPush& push, ClothLoad& load);
/// The load's forces, as large as they are, but along an axis.
std::vector<contact::VertexForce> forces_along(const ClothLoad& load, int axis);
/// Chooses the part for the next frame by the answers, when all three are known.
void choose_part(double mass, double dt, ClothLoad& load);

/// Of all forces together, and of their sizes [N].
Vec3d total_force(const ClothLoad& load);
double sum_of_sizes(const ClothLoad& load);

}  // namespace turgor
