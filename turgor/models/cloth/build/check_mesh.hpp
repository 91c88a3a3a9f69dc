// Checks of a mesh and of parameters, notes about unusual edges, and welding.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Errors as in build, except for the thickness.
Status check_mesh(const TriMesh& mesh);
Status check_params(const Params& params);

/// Note about edges of more than two triangles: "2 edges belong to more than two triangles (5-6, 8-9)".
/// Empty: no such edge.
std::string crowded_edges(const TriMesh& mesh);

/// Note about edges whose two triangles lie on each other, to one degree: "2 edges are folded flat (5-6,
/// 8-9)". Empty: no such edge.
std::string folded_edges(const TriMesh& mesh);

/// Merges vertices closer than `distance` with the one of the smallest number. Triangles that lose their area
/// are removed. `vertex` becomes the new number of each old vertex.
TriMesh welded(const TriMesh& mesh, double distance, std::vector<int>& vertex);

/// List of ids: "vertex 7", "vertices 3, 4, 9 and 12 more".
std::string named(const std::string& one, const std::string& many, const std::vector<int>& ids);

}  // namespace turgor::cloth
