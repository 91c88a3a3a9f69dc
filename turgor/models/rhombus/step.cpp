// Displacement of all vertices in a frame: geodesic distances from each touch, then the displacements by its
// chains and by the bulge around them.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/rhombus/fields.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/rhombus/tool_touch.hpp"

namespace turgor::rhombus {

namespace {

constexpr double kTwistUnits = 4;    // a rotation of held tissue fades over so many units
constexpr double kFoldReach = 4;     // the surface around a fold contracts within so many half openings
constexpr std::size_t kGrain = 512;  // vertices

constexpr double kFoldSqueezed = 0.8;  // fraction of closing: tissue keeps some thickness between closed jaws

/// Smooth step from 1 at x = 0 to 0 at x = 1, with zero slope at both ends.
double fading(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return (1 - x) * (1 - x) * (1 + 2 * x);
}

/// Data of a touch for the displacement of its vertices.
struct MovingTouch {
  const ToolTouch* touch;
  const GeodesicField* distances;
  MoveComponents components;
  ChainShape depth, drag;
  double scale = 1;        // of the chains
  double width = 0;        // of a unit [m]
  double half_fold = 0;    // half the length of the surface between the jaws when they closed [m]
  double ring_center = 0;  // position of the bulge's crest [units]
  bool turned = false;
};

/// Mean index of the displacement, a measure of the dent's width. Continuous when units join.
double mean_index(const ChainShape& shape) {
  double sum = 0, moment = 0;
  for (int j = 0; j < shape.units; j++)
    sum += shape.depth[std::size_t(j)], moment += j * shape.depth[std::size_t(j)];
  return sum != 0 ? moment / sum : 0;
}

MovingTouch make_moving_touch(const Model& model, const ToolTouch& t) {
  // shapes of both chains
  MovingTouch m{.touch = &t, .distances = nullptr, .components = components_of(t.moved, t.foot.normal)};
  TURGOR_CHECK(is_unit(t.foot.normal), "the normal at a touch is a unit vector");
  m.depth = shape_of_force(model.chain, t.depth_force);
  m.drag = shape_of_force(model.chain, -t.drag_force);
  m.scale = scale_at(t.tip, t.depth_whole);
  m.width = unit_width(model.chain) * m.scale;
  m.ring_center = 2 + 2 * mean_index(m.depth);
  // held tissue
  if (!t.holding) return m;
  m.half_fold = 0.5 * t.held_opening;
  m.turned = !(t.turn == Mat3d{});
  return m;
}

/// Radius within which a touch displaces vertices [m].
double motion_radius(const Model& model, const MovingTouch& m) {
  double units = std::max(m.depth.units, m.drag.units);
  if (model.params.bulge > 0) units = std::max(units, 2 * m.ring_center);
  if (m.turned) units = std::max(units, kTwistUnits);
  return std::max(units * m.width, kFoldReach * m.half_fold);
}

/// Recomputes the distances when the touch has moved, or when it extends beyond them. The computed radius is
/// somewhat larger, so that a growing dent does not need new distances in every frame.
void update_distances(const Model& model, const MovingTouch& m, GeodesicField& field) {
  const TrianglePoint& at = m.touch->foot.at;
  const double radius = motion_radius(model, m);
  const bool same = !field.distance.empty() && at.triangle == field.source.triangle &&
                    norm(at.position - field.source.position) <= 1e-6 * model.surface.mean_edge;
  if (same && radius <= field.radius) return;
  measure_distances(model.surface, at, same ? 1.25 * radius : 1.1 * radius, field);
}

/// Displacement by closing jaws: the surface between them contracts and rises into a fold, and the surface
/// around follows.
Vec3d fold_move(const MovingTouch& m, Vec3d from_foot, double distance) {
  const ToolTouch& t = *m.touch;
  const double h = m.half_fold;
  if (!(h > 0 && t.closing > 0)) return {};
  const double x = dot(from_foot, t.fold_axis), near = fading((distance / h - 1) / (kFoldReach - 1));
  const double inwards = std::clamp(x, -h, h), rise = h * fading(std::abs(x) / h);
  return (t.foot.normal * rise - t.fold_axis * inwards) * (near * kFoldSqueezed * t.closing);
}

/// Displacement of a vertex by one touch.
Vec3d chain_move(const MovingTouch& m, Vec3d x, double distance) {
  const ToolTouch& t = *m.touch;
  const Vec3d normal = t.foot.normal, from_foot = x - t.foot.at.position;
  const double s = distance / m.width;
  // dent: along the normal and outwards
  const ShapePoint dent = shape_at(m.depth, s);
  const Vec3d outwards = normalized(from_foot - normal * dot(from_foot, normal));
  Vec3d move = outwards * (dent.outward * m.scale * t.depth_fraction);
  if (m.depth.units > 0) move -= normal * (dent.depth / m.depth.depth[0] * m.components.depth);
  // drag along the surface
  if (m.drag.units > 0)
    move += m.components.along * (shape_at(m.drag, s).depth / m.drag.depth[0] * m.components.drag);
  if (!t.holding) return move;
  // rotation and fold of held tissue
  if (m.turned) move += (t.turn * from_foot - from_foot) * fading(s / kTwistUnits);
  return move + fold_move(m, from_foot, distance);
}

/// Height of the bulge: a ring around the dent.
double ring(const MovingTouch& m, double distance) {
  const double off = std::abs(distance / m.width - m.ring_center) / m.ring_center;
  return std::abs(m.components.depth) * fading(off);
}

/// Adds the displacements of a touch to its vertices.
struct AddMoves {
  const Model& model;
  const MovingTouch& touch;
  State& state;

  void operator()(std::size_t i) const {
    const auto v = std::size_t(touch.distances->reached[i]);
    const double distance = touch.distances->distance[v];
    state.displacement[v] += chain_move(touch, model.surface.vertices[v], distance);
    if (model.params.bulge > 0) state.ring[v] += ring(touch, distance);
  }
};

/// Calls visit(triangle) once for every triangle with a listed vertex.
template <class Visit>
void for_each_moved_triangle(const Surface& s, const State& state, const Visit& visit) {
  const auto is_listed = [&](int v) { return state.listed[std::size_t(v)] != 0; };
  for (const int v : state.moved)
    for (const int corner : corners_of(s, v)) {
      const Int3 t = s.triangles[std::size_t(corner / 3)];
      const int first = is_listed(t.x) ? t.x : is_listed(t.y) ? t.y : t.z;
      if (first == v) visit(corner / 3);
    }
}

/// Change of the organ's volume when the rings are raised by a height h: c0 + c1 h + c2 h² + c3 h³ [m³].
struct GainedVolume {
  double c0 = 0, c1 = 0, c2 = 0, c3 = 0;

  double at(double h) const { return c0 + h * (c1 + h * (c2 + h * c3)); }
  double slope(double h) const { return c1 + h * (2 * c2 + 3 * h * c3); }
};
GainedVolume gained_volume(const Surface& s, const State& state, Vec3d origin) {
  GainedVolume sum;
  for_each_moved_triangle(s, state, [&](int t) {
    const Int3 v = s.triangles[std::size_t(t)];
    Vec3d rest[3], now[3], ring_direction[3];
    // corners at rest, displaced, and the derivative by h
    for (int i = 0; i < 3; i++) {
      const auto k = std::size_t(v[i]);
      rest[i] = s.vertices[k] - origin;
      now[i] = rest[i] + state.displacement[k];
      ring_direction[i] = s.normals[k] * state.ring[k];
    }
    // signed volume of the tetrahedron with the origin, by powers of h
    const Vec3d n = cross(now[1], now[2]),
                m = cross(ring_direction[1], now[2]) + cross(now[1], ring_direction[2]),
                o = cross(ring_direction[1], ring_direction[2]);
    sum.c0 += dot(now[0], n) - dot(rest[0], cross(rest[1], rest[2]));
    sum.c1 += dot(ring_direction[0], n) + dot(now[0], m);
    sum.c2 += dot(ring_direction[0], m) + dot(now[0], o);
    sum.c3 += dot(ring_direction[0], o);
  });
  return {sum.c0 / 6, sum.c1 / 6, sum.c2 / 6, sum.c3 / 6};
}

/// Raises the rings until they contain the fraction `bulge` of the pressed-in volume.
void bulge(const Exec& exec, const Model& model, State& state, StepReport& report) {
  // volume as a polynomial of the rings' height
  TURGOR_CHECK(!state.moved.empty(), "a bulge surrounds a press");
  const Vec3d origin = model.surface.vertices[std::size_t(state.moved[0])];
  const GainedVolume gained = gained_volume(model.surface, state, origin);
  report.pressed_volume = -gained.c0;
  const double goal = (1 - model.params.bulge) * gained.c0;
  // Newton's method for the height
  double height = 0;
  for (int i = 0; i < 4 && gained.slope(height) > 0; i++)  // nearly linear for a low ring
    height -= (gained.at(height) - goal) / gained.slope(height);
  // raise the rings
  const auto raise = [&](std::size_t k) {
    const auto v = std::size_t(state.moved[k]);
    state.displacement[v] += model.surface.normals[v] * (height * state.ring[v]);
  };
  parallel_for(exec, state.moved.size(), raise, kGrain);
}

void clear_moves(State& state) {
  for (const int moved : state.moved) {
    const auto v = std::size_t(moved);
    state.displacement[v] = {}, state.ring[v] = 0, state.listed[v] = 0;
  }
  state.moved.clear();
  if (!state.carried.empty()) std::fill(state.displacement.begin(), state.displacement.end(), Vec3d{});
}

/// Adds the displacements by loads. Both are small where they overlap.
void add_carried(State& state) {
  TURGOR_CHECK(state.carried.empty() || state.carried.size() == state.displacement.size(),
               "loads displace every vertex");
  for (std::size_t v = 0; v < state.carried.size(); v++) state.displacement[v] += state.carried[v];
}

double largest_size(const std::vector<Vec3d>& displacement) {
  double largest2 = 0;
  for (const Vec3d u : displacement) largest2 = std::max(largest2, dot(u, u));
  return std::sqrt(largest2);
}

/// Lists the vertices of a touch that are not yet listed.
void list_moved(State& state, const GeodesicField& field) {
  for (const int v : field.reached) {
    if (state.listed[std::size_t(v)]) continue;
    state.listed[std::size_t(v)] = 1;
    state.moved.push_back(v);
  }
}

}  // namespace

StepReport step(const Exec& exec, const Model& model, State& state) {
  // undo the last frame
  TURGOR_CHECK(state.displacement.size() == model.surface.vertices.size(), "every vertex has a displacement");
  TURGOR_CHECK(state.distances.size() == state.touches.size(), "every touch has a field of distances");
  clear_moves(state);
  StepReport report;
  // displacements by each touch
  for (std::size_t k = 0; k < state.touches.size(); k++) {
    const ToolTouch& t = state.touches[k];
    if (!(dot(t.moved, t.moved) > 0) && !t.holding) continue;
    MovingTouch m = make_moving_touch(model, t);
    update_distances(model, m, state.distances[k]);
    m.distances = &state.distances[k];
    list_moved(state, *m.distances);
    parallel_for(exec, m.distances->reached.size(), AddMoves{model, m, state}, kGrain);
  }
  // bulge and loads
  if (state.moved.empty() && state.carried.empty()) return report;
  if (model.params.bulge > 0 && !state.moved.empty()) bulge(exec, model, state, report);
  add_carried(state);
  report.largest_displacement = largest_size(state.displacement);
  report.finite = std::isfinite(report.largest_displacement);
  return report;
}

double energy(const Model& model, const State& state) {
  double sum = 0;
  for (const ToolTouch& t : state.touches) {
    if (!(dot(t.moved, t.moved) > 0)) continue;
    const double own =
        tip_energy(model.chain, t.tip, t.depth_whole, t.depth_force) * t.depth_fraction * t.depth_fraction +
        tip_energy(model.chain, t.tip, 0, -t.drag_force) * t.drag_fraction * t.drag_fraction;
    sum += stiffness_of(model, t) * own + 0.5 * dot(t.elastic, t.moved - t.demand);
  }
  return sum;
}

std::size_t memory_bytes(const Model& model, const State& state) { return bytes_of_fields(model, state); }

std::uint64_t state_hash(const State& state) {
  return hash_of_fields(state, 0, state.displacement.size(), kHashSeed);
}

}  // namespace turgor::rhombus
