// Paths of a press and of a grasp: targets become points of the body's surface at rest, with the tool along
// the surface normal.
#pragma once

#include <span>

#include "turgor/core/vec.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

/// Closed triangle surface at rest, counter-clockwise seen from outside.
struct RestSurface {
  std::span<const Vec3d> vertices;  // [m]
  std::span<const Int3> triangles;
};

/// A point of the surface and the normal around it.
struct SurfaceSample {
  Vec3d point;   // [m]
  Vec3d normal;  // unit, outward: mean over `reach` around the point
};

/// Point of the surface nearest to `target`. In fractions of the surface's box, a component of exactly 0 or 1
/// selects the surface seen from that side of the box instead.
SurfaceSample sample_surface(const RestSurface& surface, Vec3d target, bool by_fraction, double reach);

/// `tip`: distance from the tool's origin to its tip, along its own -z; `radius`: half of its width [m].
ToolPath press_path(const RestSurface& surface, const Press& press, double tip, double radius);
ToolPath grasp_path(const RestSurface& surface, const Grasp& grasp, double tip, double radius);

}  // namespace turgor
