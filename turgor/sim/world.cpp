#include "turgor/sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

template <class T>
T&& moved(Result<T>& result) {
  return std::move(*result);
}

/// Where a ray from `point` along an axis of the patient frame first meets the body; `point` when it does
/// not.
Vec3d first_body_point(const lattice::Model& model, Vec3d point, Vec3d direction, double length) {
  const Grid& grid = model.grid;
  const double stride = 0.5 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  for (double t = 0; t <= length; t += stride) {
    const Vec3d index = index_at(grid, point + direction * t);
    const Int3 node{int(std::lround(index.x)), int(std::lround(index.y)), int(std::lround(index.z))};
    if (!contains(grid, node)) continue;
    if (lattice::is_body(model.tissue[std::size_t(node_slot(model.lattice, node))]))
      return point + direction * t;
  }
  return point;
}

Vec3d placed_point(const lattice::Model& model, const BodyBox& box, Vec3d fraction) {
  const Vec3d extent = box.high - box.low;
  Vec3d point = box.low + hadamard(fraction, extent);
  for (int axis = 0; axis < 3; axis++) {
    if (fraction[axis] != 0 && fraction[axis] != 1) continue;
    Vec3d inwards;
    inwards[axis] = fraction[axis] == 0 ? 1 : -1;
    return first_body_point(model, point, inwards, extent[axis]);
  }
  return point;
}

/// The part of the path that the blade passes in this frame.
double blade_fraction(const Cut& cut, double time) {
  if (time < cut.blade.start || (cut.blade.duration > 0 && time == cut.blade.start)) return 0;
  return cut.blade.duration > 0 ? std::min(1.0, (time - cut.blade.start) / cut.blade.duration) : 1;
}

/// Moves the blade of a cut to where it is at the end of this frame.
Status advance_blade(World& world, std::size_t index) {
  Cut& cut = world.cuts[index];
  const double fraction = blade_fraction(cut, (world.frame + 1) * world.dt * (1 + 1e-12));
  if (fraction <= cut.done) return Done{};
  LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
  if (!cut.path) {
    Result<lattice::BladePath> path = lattice::lay_blade(body.model, body.state, cut.blade);
    if (!path) return path.error();
    cut.path = std::move(*path);
    if (cut.blade.width > 0)
      cut.edges = lattice::cut_region(body.model, body.state, *cut.path, cut.blade.width, int(index));
  }
  if (cut.blade.width == 0)
    cut.edges += lattice::cut_edges(body.model, body.state, *cut.path, cut.done, fraction, int(index));
  cut.done = fraction;
  return Done{};
}

Status load_touched(const Exec& exec, const Scene& scene, const BeginWork& begin, World& world) {
  for (const SfemScene& body_scene : scene.sfem_bodies) {
    Result<SfemBody> body = load_sfem(exec, body_scene, begin);
    if (!body) return body.error();
    world.sfem_bodies.push_back(moved(body));
  }
  for (const RhombusScene& body_scene : scene.rhombus_bodies) {
    Result<RhombusBody> body = load_rhombus(exec, body_scene, world.sfem_bodies, begin);
    if (!body) return body.error();
    world.rhombus_bodies.push_back(moved(body));
  }
  for (const ToolScene& tool_scene : scene.tools) {
    TouchedBody& body = touched_body(world, tool_scene.body);
    if (tool_scene.body.kind == BodyKind::kLattice)
      make_rest_surface(world.lattice_bodies[std::size_t(tool_scene.body.index)]);
    Result<TouchingTool> tool = load_tool(tool_scene, body.name, rest_surface(world, tool_scene.body));
    if (!tool) return tool.error();
    body.tool_indices.push_back(int(world.tools.size()));
    world.tools.push_back(moved(tool));
  }
  for (RhombusBody& body : world.rhombus_bodies) {
    if (body.tool_indices.size() > std::size_t(rhombus::kMaxTouches))
      return Error{fmt::format("{}: expected at most {} tools that touch it, found {}", body.name,
                               rhombus::kMaxTouches, body.tool_indices.size())};
    begin_touch(body, world.tools);
  }
  for (std::size_t o = 0; o < world.sfem_bodies.size(); o++) {
    const SfemScene& s = scene.sfem_bodies[o];
    const Status begun = begin_touch(exec, world.sfem_bodies[o], world.tools, {s.viscosity, s.viscous_time});
    if (!begun) return Error{fmt::format("{}.patch: {}", s.place, begun.error().message)};
  }
  for (LatticeBody& body : world.lattice_bodies) begin_touch(body, world.tools);
  return Done{};
}

/// Bodies and tools as a recording fills them: by name, and with the tools' shapes to be drawn.
Status name_touched(const Scene& scene, World& world) {
  for (const SfemScene& body : scene.sfem_bodies) {
    world.sfem_bodies.emplace_back();
    world.sfem_bodies.back().name = body.name;
  }
  for (const RhombusScene& body : scene.rhombus_bodies) {
    world.rhombus_bodies.emplace_back();
    world.rhombus_bodies.back().name = body.name;
  }
  for (const ToolScene& tool_scene : scene.tools) {
    Result<TouchingTool> tool = load_tool_shape(tool_scene);
    if (!tool) return tool.error();
    touched_body(world, tool_scene.body).tool_indices.push_back(int(world.tools.size()));
    world.tools.push_back(moved(tool));
  }
  return Done{};
}

}  // namespace

BodyBox body_box(const lattice::Model& model) {
  constexpr double kFar = std::numeric_limits<double>::max();
  BodyBox box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  const Int3 size = model.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        if (!lattice::is_body(model.tissue[std::size_t(node_slot(model.lattice, i, j, k))])) continue;
        const Vec3d point = point_at(model.grid, {double(i), double(j), double(k)});
        box = {min(box.low, point), max(box.high, point)};
      }
  return box;
}

lattice::Incision placed_blade(const lattice::Model& model, const lattice::Incision& fractions) {
  const BodyBox box = body_box(model);
  lattice::Incision blade = fractions;
  blade.from = placed_point(model, box, fractions.from);
  blade.to = placed_point(model, box, fractions.to);
  return blade;
}

Result<World> load_world(const Exec& exec, const Scene& scene, const BeginWork& begin, Purpose purpose) {
  World world;
  world.gravity = scene.gravity;
  world.dt = 1 / scene.frame_rate;
  for (const LatticeScene& body_scene : scene.lattice_bodies) {
    Result<LatticeBody> body = load_lattice(exec, body_scene, begin);
    if (!body) return body.error();
    world.lattice_bodies.push_back(moved(body));
  }
  for (const IncisionScene& incision : scene.incisions) {
    const LatticeBody& body = world.lattice_bodies[std::size_t(incision.body)];
    Cut cut;
    cut.body = incision.body;
    cut.blade = incision.by_fraction ? placed_blade(body.model, incision.blade) : incision.blade;
    const Result<lattice::BladePath> trial = lattice::lay_blade(body.model, body.state, cut.blade);
    if (!trial) return Error{fmt::format("{}: {}", incision.place, trial.error().message)};
    world.cuts.push_back(std::move(cut));
  }
  const Status bodies =
      purpose == Purpose::kSimulate ? load_touched(exec, scene, begin, world) : name_touched(scene, world);
  if (!bodies) return bodies.error();
  for (const ClothScene& cloth_scene : scene.cloth_bodies) {
    Result<ClothBody> body = load_cloth(exec, cloth_scene);
    if (!body) return body.error();
    world.cloth_bodies.push_back(moved(body));
  }
  return world;
}

Result<FrameReport> step(const Exec& exec, World& world, bool measure_residual) {
  const Timer timer;
  FrameReport report;
  for (std::size_t c = 0; c < world.cuts.size(); c++)
    if (const Status status = advance_blade(world, c); !status) return status.error();
  for (LatticeBody& body : world.lattice_bodies) {
    // Position-based dynamics has no forces that could be left over.
    const bool has_forces = body.model.params.solver.method == lattice::Method::kDescent;
    const std::vector<lattice::NodeLoad> loads = node_loads(body);
    const lattice::Inputs inputs{.gravity = body.has_gravity ? world.gravity : Vec3d{},
                                 .measure_residual = measure_residual && has_forces,
                                 .loads = loads};
    const double now = time_of(world);
    const lattice::StepReport done = step_lattice(exec, body, world.tools, inputs, now, now + world.dt);
    remember_deepest(body, now + world.dt);
    report.finite = report.finite && done.finite;
    report.largest_speed = std::max(report.largest_speed, double(done.largest_speed));
    report.residual.largest = std::max(report.residual.largest, done.residual.largest);
    report.residual.rms = std::max(report.residual.rms, done.residual.rms);
  }
  for (SfemBody& body : world.sfem_bodies) {
    touch_body(exec, body, world.tools, time_of(world), time_of(world) + world.dt);
    turn_body(exec, body);
    remember_deepest(exec, body, time_of(world) + world.dt);
  }
  for (RhombusBody& body : world.rhombus_bodies) {
    touch_body(body, world.tools, time_of(world), time_of(world) + world.dt);
    remember_deepest(exec, body, time_of(world) + world.dt);
  }
  for (ClothBody& body : world.cloth_bodies) {
    report.finite = step_cloth(exec, body, world, measure_residual) && report.finite;
    report.largest_speed = std::max(report.largest_speed, body.samples.back().largest_speed);
  }
  load_bodies(exec, world);
  world.frame++;
  report.seconds = timer.seconds();
  return report;
}

}  // namespace turgor
