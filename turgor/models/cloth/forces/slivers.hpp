// Slivers: triangles that are much thinner than those around them, as triangulations of random points have
// along their hull. Single-precision positions do not resolve their strain and curvature, and their share of
// the area is small. They therefore carry no membrane force, and their edges turn freely. Where the border
// bends, their chords shorten, and sweep through the cloth beside them: self-contacts and CCD leave them out.
#pragma once

#include <vector>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::cloth {

/// True (1) for each triangle whose height over its longest side is below a tenth of the mean height of the
/// triangles around it, and whose corners all belong to other triangles.
std::vector<char> find_slivers(const TriMesh& mesh);

}  // namespace turgor::cloth
