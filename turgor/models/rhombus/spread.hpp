// Distributed loads on the surface, such as cloth that rests on it. For small displacements a chain
// corresponds to an incompressible half space (tip.hpp), which also responds to distributed loads. A force f
// on its surface displaces the point at r by
//
//     u = (f + r̂ (r̂·f)) / (π E* r)
//
// twice the displacement inside an infinite body [Kelvin; Mindlin 1936], for any shape of the surface. Each
// vertex bears its force over its own area [de Goes, James 2017]. The response is linear, as distributed
// loads cause small displacements. Equations: docs/models/rhombus.md.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

/// Force on a vertex.
struct Load {
  int vertex;
  Vec3d force;  // [N]
};

/// E* = E/(1 − ν²) of the half space that matches the chain at first touch [Pa]. A disc of the chain's tip
/// radius R bears 2 E* R a depth. A chain without a tip uses the width of its units.
double half_space_modulus(const Chain& chain);

/// Displacement of every vertex by loads [m].
void displacements_of(const Exec& exec, const Model& model, std::span<const Load> loads,
                      std::vector<Vec3d>& displacement);

/// Displacement of a vertex by a unit force on another one: a block of 3 × 3, column-major [m/N].
void displacement_block(const Model& model, int vertex, int loaded, std::span<double, 9> block);

/// Upper bound of the displacement of any vertex by loads of these magnitudes in any direction [m].
double farthest_move(const Exec& exec, const Model& model, std::span<const Load> loads);

}  // namespace turgor::rhombus
