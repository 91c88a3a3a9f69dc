// A haptic tick: each tool finds its foot on the surface at rest, which says where it wants the touched
// point; tools that touch near each other share what they move; chains turn that into forces; the material
// remembers.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/rhombus/touching.hpp"

namespace turgor::rhombus {

namespace {

constexpr double kAtRest = 1e-7;  // the surface is there when it is this near [m]

bool is_finite(Vec3d x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

bool is_valid(const TouchInput& in) {
  for (const Vec3d axis : in.axes.column)
    if (!is_finite(axis)) return false;
  return is_finite(in.position) && std::isfinite(in.radius) && in.radius >= 0 && std::isfinite(in.grip) &&
         std::isfinite(in.opening);
}

/// Where the foot of a tool is. While it holds, it stays.
Foot foot_of(const Model& model, const Touching& t, const TouchInput& in) {
  return t.touching || t.holding ? follow_foot(model.surface, t.foot, in.position)
                                 : find_foot(model.surface, model.tree, in.position);
}

void begin_hold(Touching& t, const TouchInput& in, double depth) {
  t.holding = true;
  t.held_point = transposed(in.axes) * (t.foot.at.place - t.foot.normal * depth - in.position);
  t.held_axes = in.axes, t.held_opening = in.opening;
  const Vec3d across = in.axes.column[0];
  t.fold_axis = normalized(across - t.foot.normal * dot(across, t.foot.normal));
}

/// How far the jaws have closed on the fold, and turned.
void follow_hold(Touching& t, const TouchInput& in) {
  t.turn = in.axes * transposed(t.held_axes);
  t.closing = t.held_opening > 0 ? std::clamp(1 - in.opening / t.held_opening, 0.0, 1.0) : 0;
}

/// What the material remembers keeps the surface from following a tool that leaves fast: the depth at which
/// it would bear no force [m].
double lagging_depth(const Model& model, const Touching& t, double dt) {
  if (model.params.viscosity.stiffening == 0) return 0;
  const ViscousStep step = viscous_step(model.params.viscosity, dt);
  const double elastic =
      (step.taken * dot(t.elastic, t.foot.normal) - step.kept * dot(t.remembered, t.foot.normal)) /
      (1 + step.taken);
  if (elastic <= 0) return 0;
  const double depth = depth_of_force(model.chain, elastic / stiffness_at(model, t.foot.at)).depth;
  return depth > kAtRest ? depth : 0;
}

/// Where the tool wants the touched point. Half-open jaws let it slip from where they hold it to where the
/// tip presses it, so that letting go is no step.
void set_demand(const Model& model, Touching& t, const TouchInput& in, double dt) {
  const Foot foot = foot_of(model, t, in);
  const double depth = pressed_depth(foot, in);
  const double grip = std::clamp(in.grip, 0.0, 1.0);
  if (grip == 0) t.holding = t.closed_empty = false;
  if (!t.holding) {
    const double lag = lagging_depth(model, t, dt);
    if (depth > 0 || lag == 0) t.foot = foot;
    t.lagging = depth < lag;
    t.demand = t.foot.normal * -std::max(depth, lag);
    if (grip == 0 || t.closed_empty) return;
    if (depth == 0) t.closed_empty = true;
    if (depth > 0) begin_hold(t, in, std::max(depth, lag));
    return;
  }
  follow_hold(t, in);
  const Vec3d held = in.position + in.axes * t.held_point - t.foot.at.place;
  t.demand = held * grip - foot.normal * (depth * (1 - grip));
}

using Weights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxTouches, kMaxTouches>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxTouches, 3>;

/// How much of its own move each tool (column) makes at the foot of each other one (row). Both ways alike.
Weights shares(const Model& model, std::span<const Touching* const> active) {
  const auto n = Eigen::Index(active.size());
  Weights w = Weights::Identity(n, n);
  std::array<ChainShape, kMaxTouches> shapes;
  for (std::size_t k = 0; k < active.size(); k++)
    shapes[k] = shape_of_force(model.chain, force_of_depth(model.chain, norm(active[k]->demand)));
  for (Eigen::Index a = 0; a < n; a++)
    for (Eigen::Index b = 0; b < a; b++) {
      const Foot &p = active[std::size_t(a)]->foot, &q = active[std::size_t(b)]->foot;
      const double s = norm(p.at.place - q.at.place) / unit_width(model.chain);
      const auto fraction = [s](const ChainShape& shape) {
        return shape_at(shape, s).depth / shape.depth[0];
      };
      const double alike = std::max(0.0, dot(p.normal, q.normal));
      w(a, b) = w(b, a) = alike * 0.5 * (fraction(shapes[std::size_t(a)]) + fraction(shapes[std::size_t(b)]));
    }
  return w;
}

/// What each tool has to move itself so that all together move every touched point where its tool wants it. A
/// tool that only presses never pulls: it leaves the points that others have moved far enough.
void share(const Model& model, std::span<Touching* const> all) {
  std::array<Touching*, kMaxTouches> active{};
  std::size_t count = 0;
  for (Touching* t : all) {
    t->moved = t->demand;
    if (dot(t->demand, t->demand) > 0) active[count++] = t;
  }
  while (count > 1) {
    const std::span<Touching* const> now(active.data(), count);
    // Tools at one point would share it in any way; this makes it equal.
    constexpr double kEvenly = 1e-3;
    Weights w = shares(model, now);
    w.diagonal().array() += kEvenly;
    Column demand(Eigen::Index(count), 3);
    for (std::size_t k = 0; k < count; k++)
      demand.row(Eigen::Index(k)) << now[k]->demand.x, now[k]->demand.y, now[k]->demand.z;
    const Column moved = w.partialPivLu().solve(demand);
    std::size_t pulling = count;
    double worst = 0;
    for (std::size_t k = 0; k < count; k++) {
      const auto row = moved.row(Eigen::Index(k));
      Touching& t = *now[k];
      t.moved = {row(0), row(1), row(2)};
      if (t.holding) continue;
      const double depth = -dot(t.moved, t.foot.normal);
      t.moved = t.foot.normal * -depth;
      if (depth < worst) worst = depth, pulling = k;
    }
    if (pulling == count) return;
    active[pulling]->moved = {};
    active[pulling] = active[--count];
  }
  if (count == 1) active[0]->moved = active[0]->demand;
}

/// Along the surface, between those of the corners.
Vec3d stiffness_gradient_at(const Model& model, const Foot& foot) {
  const Int3 t = model.surface.triangles[std::size_t(foot.at.triangle)];
  const auto& g = model.stiffness_gradient;
  const Vec3d w = foot.at.weights;
  const Vec3d sum = g[std::size_t(t.x)] * w.x + g[std::size_t(t.y)] * w.y + g[std::size_t(t.z)] * w.z;
  return sum - foot.normal * dot(sum, foot.normal);
}

/// Elastic force on the tool. The two chains, along the normal and along the surface, have energies of their
/// own; where stiffness varies over the surface, the tool is pushed off the stiffer side.
Vec3d elastic_force(const Model& model, Touching& t) {
  const MoveParts moved = parts_of(t.moved, t.foot.normal), demand = parts_of(t.demand, t.foot.normal);
  const SharedMove depth = shared_move(moved.depth, demand.depth),
                   drag = shared_move(moved.drag, demand.drag);
  t.depth_force = force_of_depth(model.chain, depth.whole, t.depth_force);
  t.drag_force = -force_of_depth(model.chain, -drag.whole, -t.drag_force);
  t.depth_part = depth.part, t.drag_part = drag.part;
  Vec3d force = t.foot.normal * (t.depth_force * depth.part) - moved.along * (t.drag_force * drag.part);
  force *= stiffness_at(model, t.foot.at);
  if (!model.stiffness.empty() && !t.holding)
    force -= stiffness_gradient_at(model, t.foot) * (chain_energy(model.chain, t.depth_force) * depth.part);
  return force;
}

void remember(const Model& model, Touching& t, Vec3d elastic, double dt) {
  const ViscousStep step = viscous_step(model.params.viscosity, dt);
  t.remembered = t.remembered * step.kept + (elastic - t.elastic) * step.taken;
  t.elastic = elastic;
}

/// Out of what it held; the surface goes back, and the tool holds nothing until it has opened.
TouchForce slip(Touching& t) {
  t.touching = t.holding = t.lagging = false;
  t.closed_empty = true;
  t.demand = t.moved = t.elastic = t.remembered = {};
  t.depth_force = t.drag_force = t.depth_part = t.drag_part = 0;
  return {.slipped = true};
}

TouchForce answer(const Model& model, Touching& t, const TouchInput& in, double dt) {
  remember(model, t, elastic_force(model, t), dt);
  const double size = norm(t.elastic + t.remembered);
  const bool bears = size <= model.params.tear;
  if (!bears && t.holding) return slip(t);
  if (!bears) {
    const double part = std::isfinite(size) ? model.params.tear / size : 0;
    t.elastic = part > 0 ? t.elastic * part : Vec3d{};
    t.remembered = part > 0 ? t.remembered * part : Vec3d{};
  }
  TouchForce out{
      .force = t.elastic + t.remembered, .depth = -dot(t.moved, t.foot.normal), .holding = t.holding};
  const bool reaches = pressed_depth(t.foot, in) > 0 && !t.lagging;
  if (!t.holding && (!reaches || dot(out.force, t.foot.normal) <= 0)) out.force = {};
  t.touching = dot(out.force, out.force) > 0;
  out.touching = t.touching;
  out.yielding = t.touching && !bears;
  out.units = depth_of_force(model.chain, t.depth_force).units;
  if (t.holding)
    out.squeeze =
        std::min(model.params.tear, stiffness_at(model, t.foot.at) *
                                        force_of_depth(model.chain, 0.5 * t.held_opening * t.closing));
  return out;
}

}  // namespace

void touch(const Model& model, std::span<Touching> touches, std::span<const TouchInput> inputs, double dt,
           std::span<TouchForce> forces) {
  TURGOR_ASSERT(inputs.size() == touches.size() && forces.size() == inputs.size(), "one input a tool");
  std::array<Touching*, kMaxTouches> valid{};
  std::array<std::size_t, kMaxTouches> number{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < inputs.size(); k++) {
    forces[k] = {.invalid_input = !is_valid(inputs[k])};
    if (forces[k].invalid_input) continue;
    Touching& t = touches[k];
    set_demand(model, t, inputs[k], dt);
    number[count] = k, valid[count++] = &t;
  }
  share(model, {valid.data(), count});
  for (std::size_t i = 0; i < count; i++) forces[number[i]] = answer(model, *valid[i], inputs[number[i]], dt);
}

}  // namespace turgor::rhombus
