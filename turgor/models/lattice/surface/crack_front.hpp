// Crack fronts of drawn cuts: lines in the tissue at which walls end. The last fine edges that a blade cut
// lie up to a fine edge above or below its lower edge, and a cell beside it opens as a whole. So walls would
// end in stairs, with a floor between them. They are closed to a smooth line, for drawing only.
#pragma once

#include <vector>

#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

/// Sides of walls near crack fronts.
struct FrontSides {
  std::vector<int> begin{0};  // by group of vertices that coincide at rest, and the end: into `vertices`
  std::vector<int> vertices;
  std::vector<Real> opening;  // by group: share of the opening that is drawn
  // vertices without another side, as where two blades cross one fine edge
  std::vector<int> lone;
  std::vector<int> beside_begin{0};  // by lone vertex, and the end: into `beside`
  std::vector<int> beside;           // vertices around it
};

/// Finds the sides of all walls. `step`: smallest spacing [m].
FrontSides find_front_sides(const BodySurface& surface, Real step);
/// Moves displaced vertices `x` (lattice frame [m]) near crack fronts.
void close_fronts(const FrontSides& sides, std::vector<Vec3>& x);

}  // namespace turgor::lattice::detail
