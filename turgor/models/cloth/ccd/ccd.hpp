// What keeps a cloth from passing through itself, at any speed: the motion of a step is looked at as a whole
// before it counts. Vertices, triangles and edges that would meet on their way move as one in that step, so
// that a cloth that begins without crossings never has any. Contacts keep layers apart by the thickness; this
// is for what escapes them.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/ccd/ccd_motion.hpp"

namespace turgor::cloth {

struct Model;
struct State;

/// Places at the begin of a step and displacements in it, of a batch of vertices or of many batches.
struct MotionBox {
  Vec3 low, high;    // [m]
  Vec3 least, most;  // displacement [m]
  Real reach = 0;    // vertices farther apart cannot have meeting triangles or edges [m]
};

/// Two edges that cross have ends nearer than √½ of the longer one; a point of a triangle is nearer to a
/// corner.
TURGOR_HD inline Real reach_of(Real longest2) { return std::sqrt(Real(0.50001) * longest2); }

TURGOR_HD inline MotionBox around(const MotionBox& a, const MotionBox& b) {
  return {min(a.low, b.low), max(a.high, b.high), min(a.least, b.least), max(a.most, b.most),
          larger(a.reach, b.reach)};
}

/// Whether anything in a and b may come nearer than the reach, seen along each axis.
TURGOR_HD inline bool may_meet(const MotionBox& a, const MotionBox& b) {
  const Real reach = larger(a.reach, b.reach);
  for (int k = 0; k < 3; k++) {
    const Real low = b.low[k] - a.high[k] - reach + smaller(b.least[k] - a.most[k], 0);
    const Real high = b.high[k] - a.low[k] + reach + larger(b.most[k] - a.least[k], 0);
    if (low > 0 || high < 0) return false;
  }
  return true;
}

/// A vertex and a triangle, or two edges (first and second, third and fourth vertex), that would meet.
struct CcdPair {
  std::array<int, 4> vertex;
  bool are_edges = false;

  auto operator<=>(const CcdPair&) const = default;
};

/// Room to work in.
struct CcdWorkspace {
  std::vector<MotionBox> boxes;             // of 32 vertices each, of pairs of these, …, of all
  std::vector<std::size_t> level_begin;     // first box of each level, and the end
  std::vector<std::vector<CcdPair>> found;  // by piece, while looking
  std::vector<CcdPair> ccd_pairs;           // of the latest step
  std::vector<CcdPair> met;  // of earlier ones, those that are near and pushed apart, ascending
  int steps_to_look = 0;     // until crossings are counted; -1 = there are none and never will be
  std::vector<int> in_impact_zone, zone;  // vertices in meetings, ascending, and what moves as one [index]
  std::vector<char> is_changed;           // by vertex: something around it moves in another way than before
};

/// The motion in State::system: `before` = places at the begin of the step, `force` = displacements [m].
/// Sets `inverse[0].x` = the longest edge of each vertex's triangles, squared [m²], and `inverse[0].y` = 2
/// where all their normals stay within 30° of one direction all the time, 1 where within 45°, else 0.
void measure_triangles(const Exec& exec, const Model& model, State& state);

/// Boxes of the motion; measure_triangles comes first.
void place_boxes(const Exec& exec, const Model& model, State& state);

/// Adds what would meet to Crossing::meetings; all vertices are looked at when `all`, else those that
/// were caught or have neighbours that were. False: nothing does, but for what moves as one already.
bool find_ccd_pairs(const Exec& exec, const Model& model, State& state, bool all);

/// Takes a step from System::before to State::x back where the cloth would pass through itself. Returns how
/// many vertices were not let go where they wanted. A cloth that crosses itself at the begin is left alone
/// until it is free.
int resolve_ccd(const Exec& exec, const Model& model, State& state);

}  // namespace turgor::cloth
