// The place of a surface under a tool: where the line along the surface's own normal meets the tool. Normals
// are those of the vertices, interpolated, so the foot moves smoothly over edges and corners of triangles and
// forces do not show them [Phong projection: Panozzo, Baran, Diamanti, Sorkine-Hornung 2013].
#pragma once

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus {

struct Foot {
  TrianglePoint at;   // of the surface at rest; its distance is unused
  Vec3d normal;       // unit, interpolated
  double height = 0;  // of the tool's point above it, along the normal; negative below the surface [m]
};

/// From the nearest point of the surface.
Foot find_foot(const Surface& surface, const TriangleTree& tree, Vec3d point);
/// From where the foot was a moment ago, over as many triangles as it takes. Where normals cross (deep below
/// a sharp ridge) it stays on the side where it was.
Foot follow_foot(const Surface& surface, const Foot& before, Vec3d point);

}  // namespace turgor::rhombus
