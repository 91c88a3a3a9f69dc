// Forceps: two jaws that turn about a hinge and close on the tissue between their tips. In the tool's frame
// the tips meet at the origin, the handles are above it (z), and the jaws open along x.
#pragma once

#include <array>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::contact {

struct Forceps {
  std::array<TriMesh, 2> jaws;  // in the closed position; the first jaw is on the side of positive x
  double hinge = 0;             // z coordinate of the hinge [m]
  double tip_radius = 0;        // radius of the ball that represents the tip in contact [m]
  double opening = 0.012;       // distance between the tips of open jaws [m]
};

/// Forceps from two closed surfaces in the tool's frame, with closed jaws. Error: a jaw without triangles or
/// with a vertex that is not finite, or jaws on the same side. Also an opening that is not between 0 and the
/// jaws' length, or closed jaws farther apart than a tenth of the opening.
Result<Forceps> build_forceps(TriMesh first, TriMesh second, double opening);

/// The same from one surface whose connected components form the jaws.
Result<Forceps> build_forceps(const TriMesh& both, double opening);

/// Mesh of both jaws with their tips `opening` apart [m].
TriMesh forceps_mesh(const Forceps& forceps, double opening);

}  // namespace turgor::contact
