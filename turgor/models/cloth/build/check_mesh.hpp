// What a mesh must be before it can be a cloth, and what is unusual about it.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Errors as in build, but for the thickness.
Status check_mesh(const TriMesh& mesh);
Status check_params(const Params& params);

/// "2 edges belong to more than two triangles (5-6, 8-9)"; empty = none does.
std::string crowded_edges(const TriMesh& mesh);

/// "2 edges lie folded flat (5-6, 8-9)": the two triangles beside them lie on each other, to a degree; empty
/// = none does.
std::string folded_edges(const TriMesh& mesh);

/// Makes one vertex of those that are closer than `distance` to one with a smaller number; triangles that
/// lose their area go. `vertex` becomes each old vertex' new one.
TriMesh welded(const TriMesh& mesh, double distance, std::vector<int>& vertex);

/// "vertex 7", "vertices 3, 4, 9 and 12 more".
std::string named(const std::string& one, const std::string& many, const std::vector<int>& ids);

}  // namespace turgor::cloth
