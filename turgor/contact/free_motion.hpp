// Free motion of vertices: motion not caused by the tools that a tick solves for, interpolated linearly from
// one frame to the next.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::contact {

struct FreeMotionInterpolation {
  bool moves = false;
  std::vector<Vec3d> from, to;  // [m]
  long ticks = 1, done = 0;     // length of the interpolation and ticks done [ticks]
};

inline double path_fraction(const FreeMotionInterpolation& path) {
  return double(path.done) / double(path.ticks);
}
inline Vec3d interpolated_motion(const FreeMotionInterpolation& path, std::size_t vertex, double fraction) {
  return path.from[vertex] * (1 - fraction) + path.to[vertex] * fraction;
}
/// Starts an interpolation from the present value to `to` over `ticks` ticks [m]. Does nothing if `to` is
/// empty.
void start_motion(FreeMotionInterpolation& path, std::span<const Vec3d> to, long ticks);

}  // namespace turgor::contact
