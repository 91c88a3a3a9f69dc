// Depth of a tool in the undeformed patch.
#include <limits>

#include "turgor/contact/tips.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Height of a point above the surface of the patch at rest; negative inside [m].
double height_at_rest(const sfem::Patch& patch, const PatchSurface& surface, Vec3d x) {
  TURGOR_CHECK(surface.normal.size() == patch.points.size(),
               "the surface has one normal per point of the patch");
  Vec3d apart, normal;
  double nearest = std::numeric_limits<double>::max();
  for (const Int3 t : patch.triangles) {
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Vec3d p = patch.points[a].x, q = patch.points[b].x, r = patch.points[c].x;
    // skip triangles by their bounding box
    constexpr double kRounding = 1 + 1e-9;
    const Vec3d from_box = x - min(max(x, min(min(p, q), r)), max(max(p, q), r));
    if (norm(from_box) > nearest * kRounding) continue;
    // nearest point and its interpolated normal
    const Vec3d w = closest_weights(x, p, q, r);
    const Vec3d d = x - (p * w.x + q * w.y + r * w.z);
    if (norm(d) >= nearest) continue;
    nearest = norm(d), apart = d;
    normal = surface.normal[a] * w.x + surface.normal[b] * w.y + surface.normal[c] * w.z;
  }
  return dot(apart, normal) < 0 ? -nearest : nearest;
}

}  // namespace

double depth_at_rest(const sfem::Patch& patch, const PatchSurface& surface, const Shape& shape,
                     const Pose& pose) {
  TURGOR_CHECK(tip_count(shape) > 0, "a shape has at least one test point");
  constexpr int kMaxTips = 16;  // of a mesh tool
  return depth_below(shape, pose, kMaxTips, [&](Vec3d x) { return height_at_rest(patch, surface, x); });
}

}  // namespace turgor::contact
