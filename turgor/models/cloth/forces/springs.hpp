// Springs of a triangle mesh: one along each edge, one across it between the facing corners. Their stiffness
// follows from the fabric, so that a sheet has the same stiffness for any orientation of its triangles.
// Equations: docs/models/cloth.md.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Springs in the numbering of the mesh, ascending by their vertices.
std::vector<Spring> make_springs(const TriMesh& mesh, const Fabric& fabric);

/// Merges springs between the same two vertices and sorts them by these.
void merge(std::vector<Spring>& springs);

}  // namespace turgor::cloth
