// Test points of a tool at a pose: balls that fill a sphere or capsule, or points of a mesh's surface. Depths
// below a surface are measured at them.
#pragma once

#include <algorithm>
#include <limits>

#include "turgor/contact/tool.hpp"

namespace turgor::contact {

constexpr int kAllTips = std::numeric_limits<int>::max();

/// Calls visit(point, radius) with about `most` test points and the radii of balls around them within the
/// tool.
template <class Visit>
void visit_tips(const Shape& shape, const Pose& pose, int most, const Visit& visit) {
  const int tips = tip_count(shape), stride = std::max(1, tips / most);
  for (int n = 0; n < tips; n += stride) {
    const Vec3d position = tip(shape, n);
    visit(to_world(pose, position), -distance(shape, position).distance);
  }
}

/// Depth of a tool's deepest point below a surface; 0 = above it [m]. height(point): above the surface,
/// negative inside.
template <class Height>
double depth_below(const Shape& shape, const Pose& pose, int most, const Height& height) {
  double deepest = 0;
  visit_tips(shape, pose, most,
             [&](Vec3d point, double radius) { deepest = std::max(deepest, radius - height(point)); });
  return deepest;
}

}  // namespace turgor::contact
