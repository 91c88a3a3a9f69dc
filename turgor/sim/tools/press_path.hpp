// A press given in a scene, as a path of the tool: places become points of the body's surface at rest, and
// the tool stands on them along the surface's normal.
#pragma once

#include <span>

#include "turgor/core/vec.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

/// A closed triangle surface at rest, counter-clockwise seen from outside.
struct RestSurface {
  std::span<const Vec3d> vertices;  // [m]
  std::span<const Int3> triangles;
};

/// A point of the surface with the normal around it.
struct SurfaceSample {
  Vec3d point;   // [m]
  Vec3d normal;  // unit, outward: the mean over `reach` around the point
};

/// The point of the surface that is nearest to `place`. In fractions of the surface's box, a component that
/// is exactly 0 or 1 means the surface seen from that side of the box instead.
SurfaceSample place_on_surface(const RestSurface& surface, Vec3d place, bool by_fraction, double reach);

/// `tip`: how far the tool reaches below its origin, along its own -z; `radius`: half of its width [m].
ToolPath press_path(const RestSurface& surface, const Press& press, double tip, double radius);
ToolPath grasp_path(const RestSurface& surface, const Grasp& grasp, double tip, double radius);

}  // namespace turgor
