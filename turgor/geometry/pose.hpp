// Rigid pose of a frame in the world.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor {

/// Columns of `axes` are the frame's axes in the world.
struct Pose {
  Vec3d position;  // [m]
  Mat3d axes;
};
TURGOR_HD inline Vec3d to_world(const Pose& pose, Vec3d x) { return pose.position + pose.axes * x; }
/// World point in the frame of a pose with orthonormal axes.
TURGOR_HD inline Vec3d to_tool(const Pose& pose, Vec3d x) {
  const Mat3d& axes = pose.axes;
  const Vec3d d = x - pose.position;
  return {dot(axes.column[0], d), dot(axes.column[1], d), dot(axes.column[2], d)};
}

}  // namespace turgor
