// The springs of a triangle mesh: one along each edge, one across each edge between the corners that face it.
// Their stiffness follows from that of the fabric, so that a sheet answers a pull the same way however its
// triangles lie.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// In the mesh's numbering, by their first vertex.
std::vector<Spring> make_springs(const TriMesh& mesh, const Fabric& fabric);

/// Springs between the same two vertices become one; ascending by these.
void merge(std::vector<Spring>& springs);

}  // namespace turgor::cloth
