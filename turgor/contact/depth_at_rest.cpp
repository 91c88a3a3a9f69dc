// How deep a tool is in a patch as it would lie without any tool.
#include <algorithm>
#include <limits>

#include "turgor/contact/touch.hpp"

namespace turgor::contact {

namespace {

/// How far a place is above the surface of the patch at rest; negative inside [m].
double height_at_rest(const sfem::Patch& patch, const PatchSurface& surface, Vec3d x) {
  Vec3d apart, normal;
  double nearest = std::numeric_limits<double>::max();
  for (const Int3 t : patch.triangles) {
    const auto a = std::size_t(t.x), b = std::size_t(t.y), c = std::size_t(t.z);
    const Vec3d p = patch.points[a].x, q = patch.points[b].x, r = patch.points[c].x;
    constexpr double kRounding = 1 + 1e-9;
    const Vec3d from_box = x - min(max(x, min(min(p, q), r)), max(max(p, q), r));
    if (norm(from_box) > nearest * kRounding) continue;
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
  constexpr int kMostTips = 16;  // of a mesh tool
  const int tips = tip_count(shape), stride = std::max(1, tips / kMostTips);
  double deepest = 0;
  for (int n = 0; n < tips; n += stride) {
    const Vec3d place = tip(shape, n);
    const double radius = -distance(shape, place).distance;  // of a ball around it in the tool
    deepest = std::max(deepest, radius - height_at_rest(patch, surface, to_world(pose, place)));
  }
  return deepest;
}

}  // namespace turgor::contact
