// Foot point of a tool on a surface: the point whose interpolated vertex normal passes through the tool
// [Phong projection: Panozzo, Baran, Diamanti, Sorkine-Hornung 2013]. It moves smoothly over edges and
// corners of triangles, so that forces do not show them.
#pragma once

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus {

struct FootPoint {
  TrianglePoint at;   // on the surface at rest; its distance is unused
  Vec3d normal;       // unit, interpolated
  double height = 0;  // of the tool above it along the normal; negative below the surface [m]
};

/// Foot point, searched from the nearest point of the surface.
FootPoint find_foot_point(const Surface& surface, const TriangleTree& tree, Vec3d point);
/// Foot point, searched from the previous one across neighboring triangles. Where normals cross (deep below a
/// sharp ridge) it stays on its previous side.
FootPoint follow_foot_point(const Surface& surface, const FootPoint& before, Vec3d point);

}  // namespace turgor::rhombus
