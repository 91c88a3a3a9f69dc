// Choice of a body's patch where the scene leaves it open: the cheapest radius and refinement that keep the
// expected force error of its tools low and fit into memory. Also the elements of a patch and its memory.
#pragma once

#include <span>
#include <vector>

#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

/// Depth below the surface down to which a patch may need Green's functions, if the scene leaves its radius
/// open [m].
double usual_touch_depth(const SolidMesh& mesh);

/// Elements of a patch around these positions. Without refinement, elements below the surface add nothing.
std::vector<int> elements_of_patch(const SfemBody& body, std::span<const Vec3d> centers, double radius);
/// Vertices whose columns of Green's functions a patch over these elements needs; ascending.
std::vector<int> columns_of_patch(const SfemBody& body, std::span<const int> elements);
/// Memory of a patch while it is built and of the columns fetched for it, with a store on demand.
struct PatchNeeds {
  double bytes = 0;
  std::vector<int> columns;  // their vertices; ascending
};
PatchNeeds needs_of_patch(const SfemBody& body, std::span<const Vec3d> centers);

/// True if the scene has `patch = false`: contact is then computed on the body's own elements around the
/// tool.
bool is_without_patch(const SfemBody& body);

/// Sets radius and refinement that the scene leaves open, from the tools at their initial positions, and
/// notes a choice that differs from the usual one. Does nothing to a body whose scene sets both.
void choose_patch(SfemBody& body, const std::vector<TouchingTool>& tools);

}  // namespace turgor
