// Continuous collision detection (CCD) of a cloth with itself. The whole motion of a step is checked before
// it is accepted. Vertices, triangles and edges that would collide form an impact zone, which moves rigidly
// by translation in that step. A cloth that starts without intersections never has any, at any speed.
// Contacts keep layers apart by the thickness; CCD catches what escapes them. Algorithm and limits:
// docs/models/cloth.md.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/ccd/ccd_motion.hpp"
#include "turgor/models/cloth/model/ccd_workspace.hpp"

namespace turgor::cloth {

struct Model;
struct State;
struct Vectors;
struct Contact;

/// Reach of primitives: intersecting edges have ends nearer than √½ of the longer edge, and a point of a
/// triangle is nearer than that to a corner.
TURGOR_HD inline Real reach_of(Real longest2) { return std::sqrt(Real(0.50001) * longest2); }

/// Bounds of two boxes together.
TURGOR_HD inline MotionBox around(const MotionBox& a, const MotionBox& b) {
  return {min(a.low, b.low), max(a.high, b.high), min(a.least, b.least), max(a.most, b.most),
          larger(a.reach, b.reach)};
}

/// Tests each axis: false if no points of a and b can come within the reach.
TURGOR_HD inline bool may_collide(const MotionBox& a, const MotionBox& b) {
  const Real reach = larger(a.reach, b.reach);
  for (int k = 0; k < 3; k++) {
    const Real low = b.low[k] - a.high[k] - reach + smaller(b.least[k] - a.most[k], 0);
    const Real high = b.high[k] - a.low[k] + reach + larger(b.most[k] - a.least[k], 0);
    if (low > 0 || high < 0) return false;
  }
  return true;
}

/// Measures the motion of the triangles: CcdMotion::normal, longest2 and flatness from start and
/// displacement. `changed`: only around vertices that CcdWorkspace::is_changed marks.
void measure_triangles(const Exec& exec, const Model& model, State& state, bool changed = false);

/// Builds the tree of motion boxes; measure_triangles must run first. `changed`: as there.
void build_boxes(const Exec& exec, const Model& model, State& state, bool changed = false);

/// Marks changed vertices and their neighbors in CcdWorkspace::is_changed. A primitive that collides with a
/// changed vertex may be nearer to its neighbor.
void mark_changed(const Exec& exec, const Model& model, const std::vector<int>& changed, CcdWorkspace& ccd);

/// Appends colliding pairs to CcdWorkspace::ccd_pairs. `changed`: as there; displacements have changed since
/// the last search at those vertices only. `list_all`: pairs whose vertices are in one impact zone already
/// are listed too. False: there are no new pairs.
bool find_ccd_pairs(const Exec& exec, const Model& model, State& state, bool changed = false,
                    bool list_all = false);

/// Lists all pairs that collide in the motion from System::previous to State::x in CcdWorkspace::ccd_pairs.
/// False: there are none, or the cloth intersects itself at the beginning and is left alone.
bool find_collisions(const Exec& exec, const Model& model, State& state);

/// Appends contacts of the pairs of find_collisions, with the normals and weights at the time of collision,
/// except implicit ones (ccd_contacts.cpp). `x`: positions that the linear system of the step starts from.
void find_collision_contacts(const Model& model, State& state, const Vectors& x, std::vector<Contact>& found);

/// Changes a step from System::previous to State::x such that the cloth does not pass through itself. Returns
/// the number of vertices in impact zones. A cloth that intersects itself at the beginning is left alone
/// until it is free.
int resolve_ccd(const Exec& exec, const Model& model, State& state);

}  // namespace turgor::cloth
