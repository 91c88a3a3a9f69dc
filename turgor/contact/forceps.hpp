// Forceps: two jaws that turn about a hinge and close on what is between their tips. In the tool's frame the
// tips meet at the origin, the handles are above it (z), and the jaws open along x.
#pragma once

#include <array>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::contact {

struct Forceps {
  std::array<TriMesh, 2> jaws;  // closed; the first on the side of positive x
  double hinge = 0;             // height about which both turn [m]
  double tip_radius = 0;        // of the ball by which the tip presses [m]
  double opening = 0.012;       // between the tips when open [m]
};

/// Two closed surfaces in the tool's frame, as they lie when the forceps are closed. Error: a jaw without
/// triangles or with places that are no numbers, jaws on the same side, jaws that never meet (closed, they
/// are farther apart than a tenth of the opening), an opening that is not between 0 and their length.
Result<Forceps> build_forceps(TriMesh first, TriMesh second, double opening);

/// The same from one surface whose loose parts are the jaws.
Result<Forceps> build_forceps(const TriMesh& both, double opening);

/// Both jaws, their tips `opening` apart [m].
TriMesh forceps_mesh(const Forceps& forceps, double opening);

}  // namespace turgor::contact
