// Part of a body that a picture leaves out, so that the inside can be seen: one side of a plane, or a wedge.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor {

struct CutawayPlane {
  Vec3d point;    // [m]
  Vec3d outward;  // unit, towards the removed side
};

/// Points on the removed side of every plane are left out: of one plane, of two that form a wedge, or none.
struct Cutaway {
  int planes = 0;
  CutawayPlane plane[2];
};

inline bool removes(const CutawayPlane& plane, Vec3d x) { return dot(x - plane.point, plane.outward) > 0; }
inline bool removes(const Cutaway& cutaway, Vec3d x) {
  for (int i = 0; i < cutaway.planes; i++)
    if (!removes(cutaway.plane[i], x)) return false;
  return cutaway.planes > 0;
}

}  // namespace turgor
