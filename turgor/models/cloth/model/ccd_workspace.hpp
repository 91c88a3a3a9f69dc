// Storage of continuous collision detection (CCD): boxes of the motion, colliding pairs, impact zones. The
// algorithm is in ccd/ccd.hpp.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::cloth {

/// Bounds of positions at the beginning of a step and of displacements in it, for a set of vertices.
struct MotionBox {
  Vec3 low, high;    // positions [m]
  Vec3 least, most;  // displacements [m]
  Real reach = 0;    // triangles and edges of vertices farther apart cannot collide [m]
};

/// Colliding pair: a vertex and a triangle, or two edges (first and second, third and fourth vertex).
struct CcdPair {
  std::array<int, 4> vertex;
  bool are_edges = false;

  auto operator<=>(const CcdPair&) const = default;
};

/// Workspace of CCD. Reused between steps.
struct CcdWorkspace {
  std::vector<MotionBox> boxes;                   // of 32 vertices each, of pairs of these, …, of all
  std::vector<std::size_t> level_begin;           // first box of each level, and the end
  std::vector<std::vector<CcdPair>> chunk_pairs;  // by chunk of boxes
  std::vector<CcdPair> ccd_pairs;                 // of the latest step
  std::vector<CcdPair>
      recent_pairs;  // of earlier steps, ascending; kept apart by contacts as long as they are near
  int steps_until_check =
      0;  // until the next test for intersections; -1 = the cloth has none, and CCD keeps it so
  std::vector<int> in_impact_zone,
      zone;  // vertices of impact zones, ascending; their zone as the index of its smallest member
  std::vector<char> is_changed;  // by vertex: its motion or that of a neighbor was changed
};

}  // namespace turgor::cloth
