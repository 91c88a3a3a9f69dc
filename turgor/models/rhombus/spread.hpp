// Loads that are spread over the surface, such as cloth that lies on it. A chain answers one tool; but what
// it stands for under a small push is a half space that keeps its volume (tip.hpp), and that answers any
// load: a force f on its surface moves the place r from it by (f + r̂ (r̂·f)) / (π E* r), twice what it does
// far inside [Kelvin; Mindlin 1936], however the surface lies. Each vertex bears its force over its own area
// [de Goes, James 2017]. Linear: a load that is spread presses no place far. Equations:
// docs/models/rhombus.md.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

/// On a vertex.
struct Load {
  int vertex;
  Vec3d force;  // [N]
};

/// E* = E/(1 − ν²) of the half space that the chain is at first touch: a disc of its tip, or of the width of
/// its units where it knows no tip, bears 2 E* R a depth [Pa].
double half_space_modulus(const Chain& chain);

/// Where loads take every vertex, from rest [m].
void displacements_of(const Exec& exec, const Model& model, std::span<const Load> loads,
                      std::vector<Vec3d>& displacement);

/// Farther than this no vertex is moved by loads as large as these, whichever way they point [m].
double farthest_move(const Exec& exec, const Model& model, std::span<const Load> loads);

}  // namespace turgor::rhombus
