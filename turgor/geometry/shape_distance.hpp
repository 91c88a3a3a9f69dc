// Signed distances to simple shapes: balls, rods, and sampled distance grids. Negative inside.
#pragma once

#include <algorithm>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Signed distance of a point to a shape, with its gradient.
struct ShapeDistance {
  double distance = 0;  // [m]
  Vec3d normal;         // unit gradient of the distance
};

/// Distance to a ball around `center`.
TURGOR_HD inline ShapeDistance ball_distance(Vec3d center, double radius, Vec3d x) {
  const Vec3d d = x - center;
  const double length = norm(d);
  return {length - radius, length > 0 ? d / length : Vec3d{0, 0, 1}};
}

/// Distance to a capsule around the segment from -half_length to half_length on the z axis.
TURGOR_HD inline ShapeDistance rod_distance(double radius, double half_length, Vec3d x) {
  return ball_distance({0, 0, std::clamp(x.z, -half_length, half_length)}, radius, x);
}

/// Distance to a surface at a grid node.
struct DistanceNode {
  float distance;  // [m]
  Vec3 normal;     // unit
};
/// A regular grid of distances as plain pointers.
struct DistanceGrid {
  Vec3d corner;                         // [m]
  double spacing = 0;                   // [m]
  Int3 size;                            // nodes along each axis
  const DistanceNode* nodes = nullptr;  // x fastest

  TURGOR_HD std::size_t count() const {
    return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
  }
};

/// Trilinear interpolation between the eight nodes around a grid index.
TURGOR_HD inline ShapeDistance interpolated(const DistanceGrid& grid, Vec3d grid_index) {
  Int3 cell;
  Vec3d t;
  for (int axis = 0; axis < 3; axis++) {
    cell[axis] = std::clamp(int(grid_index[axis]), 0, grid.size[axis] - 2);
    t[axis] = grid_index[axis] - cell[axis];
  }
  double distance = 0;
  Vec3d normal;
  for (int corner = 0; corner < 8; corner++) {
    const Int3 bit{corner & 1, corner >> 1 & 1, corner >> 2};
    const double w = (bit.x ? t.x : 1 - t.x) * (bit.y ? t.y : 1 - t.y) * (bit.z ? t.z : 1 - t.z);
    const auto n =
        std::size_t(((cell.z + bit.z) * grid.size.y + cell.y + bit.y) * grid.size.x + cell.x + bit.x);
    distance += w * grid.nodes[n].distance;
    normal += w * Vec3d(grid.nodes[n].normal);
  }
  const double length = norm(normal);
  return {distance, length > 0 ? normal / length : Vec3d{0, 0, 1}};
}

/// Outside the grid: distance to the surface point nearest to the closest point of the grid's border.
TURGOR_HD inline ShapeDistance grid_distance(const DistanceGrid& grid, Vec3d x) {
  const Vec3d index = (x - grid.corner) / grid.spacing;
  const Vec3d inside = max(min(index, Vec3d(grid.size) - Vec3d{1, 1, 1}), Vec3d{});
  const ShapeDistance near = interpolated(grid, inside);
  if (inside == index) return near;
  const Vec3d surface = grid.corner + inside * grid.spacing - near.normal * near.distance;
  return ball_distance(surface, 0, x);
}

/// Number of balls along a rod's axis for site search. Points between the balls are found as well, because a
/// site's distance is that to the whole rod.
TURGOR_HD inline int rod_ball_count(double radius, double half_length) {
  constexpr double kApart = 4;  // radii
  constexpr int kMost = 5;
  return half_length > 0 ? std::min(kMost, 2 + int(2 * half_length / (kApart * radius))) : 1;
}
/// Center of one of them.
TURGOR_HD inline Vec3d rod_ball(double half_length, int count, int index) {
  const int last = count - 1;
  return {0, 0, last == 0 ? 0 : half_length * (2.0 * index / last - 1)};
}

}  // namespace turgor
