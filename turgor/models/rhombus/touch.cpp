// Haptic tick. Each tool's foot point on the surface at rest gives the displacement that the tool requires of
// the touched point. Tools near each other share the displacement. The chains convert it to forces, and
// viscosity is added.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/rhombus/tool_touch.hpp"

namespace turgor::rhombus {

namespace {

constexpr double kAtRest = 1e-7;  // distance at which the surface counts as recovered [m]

bool is_valid(const TouchInput& in) {
  for (const Vec3d axis : in.axes.column)
    if (!is_finite(axis)) return false;
  return is_finite(in.position) && std::isfinite(in.radius) && in.radius >= 0 && std::isfinite(in.grip) &&
         std::isfinite(in.opening);
}

/// Foot point of a tool, tracked while it touches.
FootPoint foot_point_of(const Model& model, const ToolTouch& t, const TouchInput& in) {
  return t.touching || t.holding ? follow_foot_point(model.surface, t.foot, in.position)
                                 : find_foot_point(model.surface, model.tree, in.position);
}

void begin_hold(ToolTouch& t, const TouchInput& in, double depth) {
  t.holding = true;
  t.held_point = transposed(in.axes) * (t.foot.at.position - t.foot.normal * depth - in.position);
  t.held_axes = in.axes, t.held_opening = in.opening;
  const Vec3d across = in.axes.column[0];
  t.fold_axis = normalized(across - t.foot.normal * dot(across, t.foot.normal));
}

/// Updates the closing and the rotation of jaws that hold tissue.
void follow_hold(ToolTouch& t, const TouchInput& in) {
  t.turn = in.axes * transposed(t.held_axes);
  t.closing = t.held_opening > 0 ? std::clamp(1 - in.opening / t.held_opening, 0.0, 1.0) : 0;
}

/// Depth at which the surface behind a fast retreating tool would bear no force, because viscosity delays its
/// recovery [m]. The total force is zero there:
///
///     f_el (1 + Σ taken) = Σ (taken f_el,0 − kept f_v)
double lagging_depth(const Model& model, const Prony& viscosity, const ToolTouch& t, double dt) {
  const int pairs = pair_count(viscosity);
  if (pairs == 0) return 0;
  double taken = 0, force = 0;
  for (std::size_t i = 0; i < std::size_t(pairs); i++) {
    const ViscousStep step = viscous_step(viscosity.pairs[i], dt);
    taken += step.taken;
    force += step.taken * dot(t.elastic, t.foot.normal) - step.kept * dot(t.remembered[i], t.foot.normal);
  }
  const double elastic = force / (1 + taken);
  if (elastic <= 0) return 0;
  const double depth = depth_of_tip(model.chain, t.tip, elastic / stiffness_of(model, t));
  return depth > kAtRest ? depth : 0;
}

/// Sets the displacement that the tool requires of the touched point. With half-open jaws it is interpolated
/// between that of holding and that of pressing, so that releasing makes no step.
void set_demand(const Model& model, const Prony& viscosity, ToolTouch& t, const TouchInput& in, double dt) {
  // foot point and depth of the tip
  const FootPoint foot = foot_point_of(model, t, in);
  const double depth = pressed_depth(foot, in);
  const double grip = std::clamp(in.grip, 0.0, 1.0);
  // opened jaws
  if (grip == 0) t.holding = t.closed_empty = false;
  if (!t.holding) t.tip = tip_on(model.chain, in.radius);
  if (!t.holding) {
    // pressing
    const double lag = lagging_depth(model, viscosity, t, dt);
    if (depth > 0 || lag == 0) t.foot = foot;
    t.lagging = depth < lag;
    t.demand = t.foot.normal * -std::max(depth, lag);
    // closing: hold what is touched
    if (grip == 0 || t.closed_empty) return;
    if (depth == 0) t.closed_empty = true;
    if (depth > 0) begin_hold(t, in, std::max(depth, lag));
    return;
  }
  // holding
  follow_hold(t, in);
  const Vec3d held = in.position + in.axes * t.held_point - t.foot.at.position;
  t.demand = held * grip - foot.normal * (depth * (1 - grip));
}

using Weights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxTouches, kMaxTouches>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxTouches, 3>;

/// Influence of each tool's own displacement (column) on the foot point of each other one (row). Symmetric.
Weights influence_matrix(const Model& model, std::span<const ToolTouch* const> active) {
  TURGOR_CHECK(active.size() <= std::size_t(kMaxTouches), "at most kMaxTouches tools touch an organ");
  const auto n = Eigen::Index(active.size());
  Weights w = Weights::Identity(n, n);
  std::array<ChainShape, kMaxTouches> shapes;
  std::array<double, kMaxTouches> scale{};
  // shape of each chain alone
  for (std::size_t k = 0; k < active.size(); k++) {
    const double depth = norm(active[k]->demand);
    shapes[k] = shape_of_force(model.chain, chain_force(model.chain, active[k]->tip, depth));
    scale[k] = scale_at(active[k]->tip, depth);
  }
  for (Eigen::Index a = 0; a < n; a++)
    for (Eigen::Index b = 0; b < a; b++) {
      const FootPoint &p = active[std::size_t(a)]->foot, &q = active[std::size_t(b)]->foot;
      // fraction at the other's foot point
      const double units = norm(p.at.position - q.at.position) / unit_width(model.chain);
      const auto fraction = [&](Eigen::Index k) {
        const ChainShape& shape = shapes[std::size_t(k)];
        return shape_at(shape, units / scale[std::size_t(k)]).depth / shape.depth[0];
      };
      // less for different normals
      const double alike = std::max(0.0, dot(p.normal, q.normal));
      w(a, b) = w(b, a) = alike * 0.5 * (fraction(a) + fraction(b));
    }
  return w;
}

/// Distributes the required displacements: all tools together move every touched point as required. A tool
/// that only presses never pulls. It drops out when others have moved its point far enough.
void distribute_moves(const Model& model, std::span<ToolTouch* const> all) {
  std::array<ToolTouch*, kMaxTouches> active{};
  std::size_t count = 0;
  // tools with a displacement
  for (ToolTouch* t : all) {
    t->moved = t->demand;
    if (dot(t->demand, t->demand) > 0) active[count++] = t;
  }
  // solve, and drop the tool that would pull most
  while (count > 1) {
    const std::span<ToolTouch* const> now(active.data(), count);
    // Regularization: tools at one point share its displacement equally.
    constexpr double kRegularization = 1e-3;
    Weights w = influence_matrix(model, now);
    w.diagonal().array() += kRegularization;
    Column demand(Eigen::Index(count), 3);
    for (std::size_t k = 0; k < count; k++)
      demand.row(Eigen::Index(k)) << now[k]->demand.x, now[k]->demand.y, now[k]->demand.z;
    // own displacements
    const Column moved = w.partialPivLu().solve(demand);
    std::size_t worst_index = count;
    double worst = 0;
    for (std::size_t k = 0; k < count; k++) {
      const auto row = moved.row(Eigen::Index(k));
      ToolTouch& t = *now[k];
      t.moved = {row(0), row(1), row(2)};
      if (t.holding) continue;
      const double depth = -dot(t.moved, t.foot.normal);
      t.moved = t.foot.normal * -depth;
      if (depth < worst) worst = depth, worst_index = k;
    }
    // drop a pulling tool
    if (worst_index == count) return;
    active[worst_index]->moved = {};
    active[worst_index] = active[--count];
  }
  if (count == 1) active[0]->moved = active[0]->demand;
}

/// Gradient of the stiffness along the surface, interpolated from the corners.
Vec3d stiffness_gradient_at(const Model& model, const FootPoint& foot) {
  const Int3 t = model.surface.triangles[std::size_t(foot.at.triangle)];
  const auto& g = model.stiffness_gradient;
  const Vec3d w = foot.at.weights;
  const Vec3d sum = g[std::size_t(t.x)] * w.x + g[std::size_t(t.y)] * w.y + g[std::size_t(t.z)] * w.z;
  return sum - foot.normal * dot(sum, foot.normal);
}

/// Elastic force on the tool. The chains along the normal and along the surface have separate energies:
///
///     F = k (f(depth) n − f(drag) t) − E ∇k
///
/// The last term pushes the tool away from the stiffer side where the stiffness k varies over the surface.
Vec3d elastic_force(const Model& model, ToolTouch& t) {
  const MoveComponents moved = components_of(t.moved, t.foot.normal),
                       demand = components_of(t.demand, t.foot.normal);
  const SharedMove depth = shared_move(moved.depth, demand.depth),
                   drag = shared_move(moved.drag, demand.drag);
  // forces of the two chains
  t.depth_force = chain_force(model.chain, t.tip, depth.whole, t.depth_force);
  t.drag_force = -chain_force(model.chain, t.tip, -drag.whole, -t.drag_force);
  t.depth_fraction = depth.fraction, t.drag_fraction = drag.fraction;
  t.depth_whole = depth.whole;
  // force on the tool, scaled by the stiffness at the foot point
  Vec3d force = t.foot.normal * (tip_force(model.chain, t.tip, depth.whole, t.depth_force) * depth.fraction) +
                moved.along * (tip_force(model.chain, t.tip, -drag.whole, -t.drag_force) * drag.fraction);
  force *= stiffness_of(model, t);
  // variable stiffness
  if (!model.stiffness.empty() && !t.holding)
    force -= stiffness_gradient_at(model, t.foot) * t.stiffness_scale *
             (tip_energy(model.chain, t.tip, depth.whole, t.depth_force) * depth.fraction);
  return force;
}

void remember(const Prony& viscosity, ToolTouch& t, Vec3d elastic, double dt) {
  const auto count = std::size_t(pair_count(viscosity));
  for (std::size_t i = count; i < t.remembered.size(); i++) t.remembered[i] = {};
  for (std::size_t i = 0; i < count; i++) {
    const ViscousStep step = viscous_step(viscosity.pairs[i], dt);
    t.remembered[i] = t.remembered[i] * step.kept + (elastic - t.elastic) * step.taken;
  }
  t.elastic = elastic;
}

/// Releases the held tissue when it slips. The tool holds nothing until it has opened.
TouchForce release_slipped(ToolTouch& t) {
  t.touching = t.holding = t.lagging = false;
  t.closed_empty = true;
  t.demand = t.moved = t.elastic = {};
  t.remembered = {};
  t.depth_force = t.drag_force = t.depth_fraction = t.drag_fraction = t.depth_whole = 0;
  return {.slipped = true};
}

/// Force of closed jaws on the fold between them, as an even disc [N].
double squeeze_force(const Model& model, const ToolTouch& t) {
  const double scale = t.tip.hold_scale, pressed = 0.5 * t.held_opening * t.closing;
  return stiffness_of(model, t) * scale * scale * force_of_depth(model.chain, pressed / scale);
}

TouchForce compute_force(const Model& model, const Prony& viscosity, ToolTouch& t, const TouchInput& in,
                         double dt) {
  // elastic and viscous force
  remember(viscosity, t, elastic_force(model, t), dt);
  const double size = norm(t.elastic + remembered_force(t));
  const bool bears = size <= model.params.tear;
  // limit of the tissue: held tissue slips, pressed tissue yields
  if (!bears && t.holding) return release_slipped(t);
  if (!bears) {
    const double cap = std::isfinite(size) ? model.params.tear / size : 0;
    t.elastic = cap > 0 ? t.elastic * cap : Vec3d{};
    for (Vec3d& pair : t.remembered) pair = cap > 0 ? pair * cap : Vec3d{};
  }
  // force on the tool; a pressing tool is never pulled
  TouchForce out{
      .force = t.elastic + remembered_force(t), .depth = -dot(t.moved, t.foot.normal), .holding = t.holding};
  const bool reaches = pressed_depth(t.foot, in) > 0 && !t.lagging;
  if (!t.holding && (!reaches || dot(out.force, t.foot.normal) <= 0)) out.force = {};
  // state
  t.touching = dot(out.force, out.force) > 0;
  out.touching = t.touching;
  out.yielding = t.touching && !bears;
  out.too_deep = t.touching && t.tip.radius > 0 && t.depth_whole > kDeepestPress * t.tip.radius;
  out.units = depth_of_force(model.chain, t.depth_force).units;
  if (t.holding) out.squeeze = std::min(model.params.tear, squeeze_force(model, t));
  TURGOR_CHECK(is_finite(out.force), "the force on a tool is finite");
  return out;
}

}  // namespace

void solve_touches(const Model& model, const Prony& viscosity, std::span<ToolTouch> touches,
                   std::span<const TouchInput> inputs, double dt, std::span<TouchForce> forces) {
  TURGOR_ASSERT(inputs.size() == touches.size() && forces.size() == inputs.size(), "one input a tool");
  // required displacements of valid tools
  TURGOR_ASSERT(touches.size() <= std::size_t(kMaxTouches), "at most kMaxTouches tools touch an organ");
  TURGOR_CHECK(dt >= 0, "time does not run backwards");
  std::array<ToolTouch*, kMaxTouches> valid{};
  std::array<std::size_t, kMaxTouches> number{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < inputs.size(); k++) {
    forces[k] = {.invalid_input = !is_valid(inputs[k])};
    if (forces[k].invalid_input) continue;
    ToolTouch& t = touches[k];
    set_demand(model, viscosity, t, inputs[k], dt);
    number[count] = k, valid[count++] = &t;
  }
  // own displacements and forces
  distribute_moves(model, {valid.data(), count});
  for (std::size_t i = 0; i < count; i++)
    forces[number[i]] = compute_force(model, viscosity, *valid[i], inputs[number[i]], dt);
}

}  // namespace turgor::rhombus
