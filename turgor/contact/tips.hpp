// Test points of a tool at a pose: balls that fill a sphere or capsule, or points of a mesh's surface. Depths
// below a surface are measured at them.
#pragma once

#include <algorithm>
#include <limits>

#include "turgor/contact/tool.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/signed_distance.hpp"

namespace turgor::contact {

constexpr int kAllTips = std::numeric_limits<int>::max();

/// Calls visit(point, position) with about `most` test points, in the world and in the tool's frame.
template <class Visit>
void visit_tips(const Shape& shape, const Pose& pose, int most, const Visit& visit) {
  const int tips = tip_count(shape), stride = std::max(1, tips / most);
  for (int n = 0; n < tips; n += stride) {
    const Vec3d position = tip(shape, n);
    visit(to_world(pose, position), position);
  }
}

/// Depth of a tool's deepest point below a surface; 0 = above it [m]. height(point): above the surface,
/// negative inside. A test point has the depth of the largest ball around it within the tool.
template <class Height>
double depth_below(const Shape& shape, const Pose& pose, int most, const Height& height) {
  double deepest = 0;
  visit_tips(shape, pose, most, [&](Vec3d point, Vec3d position) {
    deepest = std::max(deepest, -distance(shape, position).distance - height(point));
  });
  return deepest;
}

/// Depth of a tool's deepest point below a closed surface; 0 = above it [m].
inline double depth_in(const SignedDistance& surface, const Shape& shape, const Pose& pose, int most) {
  const double reach = 2 * bounding_radius(shape);
  const Box box{surface.low - Vec3d{reach, reach, reach}, surface.high + Vec3d{reach, reach, reach}};
  return depth_below(shape, pose, most,
                     [&](Vec3d x) { return squared_distance(box, x) > 0 ? reach : surface.at(x); });
}

}  // namespace turgor::contact
