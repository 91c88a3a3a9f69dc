// Depth of a tool in the undeformed patch.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/tips.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Offset of a point from the nearest point of a triangle of the patch at rest.
Vec3d offset_from(const sfem::Patch& patch, Int3 t, Vec3d x, Vec3d& weights) {
  const Vec3d p = patch.points[std::size_t(t.x)].x, q = patch.points[std::size_t(t.y)].x,
              r = patch.points[std::size_t(t.z)].x;
  weights = closest_weights(x, p, q, r);
  return x - (p * weights.x + q * weights.y + r * weights.z);
}

/// Height of a point above the surface of the patch at rest; negative inside [m]. `near`: a triangle that may
/// be near, and then the nearest one.
double height_at_rest(const sfem::Patch& patch, const PatchSurface& surface, Vec3d x, std::size_t& near) {
  TURGOR_CHECK(surface.normal.size() == patch.points.size(),
               "the surface has one normal per point of the patch");
  constexpr double kRounding = 1 + 1e-9;
  Vec3d w;
  Vec3d apart = offset_from(patch, patch.triangles[near], x, w);
  double bound = dot(apart, apart) * kRounding, nearest = std::numeric_limits<double>::max();
  Vec3d normal;
  for (std::size_t n = 0; n < patch.triangles.size(); n++) {
    const Int3 t = patch.triangles[n];
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Vec3d p = patch.points[a].x, q = patch.points[b].x, r = patch.points[c].x;
    // skip triangles by their bounding box
    const Vec3d from_box = x - min(max(x, min(min(p, q), r)), max(max(p, q), r));
    if (dot(from_box, from_box) > bound) continue;
    // nearest point and its interpolated normal
    const Vec3d d = offset_from(patch, t, x, w);
    const double squared = dot(d, d);
    if (squared >= nearest) continue;
    nearest = squared, bound = std::min(bound, squared * kRounding), apart = d, near = n;
    normal = surface.normal[a] * w.x + surface.normal[b] * w.y + surface.normal[c] * w.z;
  }
  return dot(apart, normal) < 0 ? -std::sqrt(nearest) : std::sqrt(nearest);
}

}  // namespace

double depth_at_rest(const sfem::Patch& patch, const PatchSurface& surface, const Shape& shape,
                     const Pose& pose) {
  TURGOR_CHECK(tip_count(shape) > 0, "a shape has at least one test point");
  constexpr int kMaxTips = 16;  // of a mesh tool
  if (patch.triangles.empty()) return 0;
  std::size_t near = 0;  // of the previous test point
  return depth_below(shape, pose, kMaxTips, [&](Vec3d x) { return height_at_rest(patch, surface, x, near); });
}

}  // namespace turgor::contact
