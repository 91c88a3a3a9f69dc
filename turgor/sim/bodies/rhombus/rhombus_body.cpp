#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/surface_files.hpp"
#include "turgor/models/rhombus/surface_stiffness.hpp"
#include "turgor/sim/bodies/lattice/load_ct.hpp"

namespace turgor {

namespace {

constexpr double kHoldTime = 0.05;  // in which a tool without jaws takes hold [s]
constexpr double kJumpWay = 1e-5;   // forces are compared over so much of a tool's way [m]

rhombus::Body body_of(const TriMesh& mesh) {
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  return body;
}

/// Vertices that the triangles use, in their order; `mesh_vertex` gets their numbers in the mesh.
rhombus::Body used_part(const std::vector<Vec3d>& vertices, const std::vector<Int3>& triangles,
                        std::vector<int>& mesh_vertex) {
  std::vector<int> number(vertices.size(), -1);
  rhombus::Body body;
  for (Int3 t : triangles) {
    for (int corner = 0; corner < 3; corner++) {
      int& n = number[std::size_t(t[corner])];
      if (n < 0) {
        n = int(body.vertices.size());
        body.vertices.push_back(vertices[std::size_t(t[corner])]);
        mesh_vertex.push_back(t[corner]);
      }
      t[corner] = n;
    }
    body.triangles.push_back(t);
  }
  return body;
}

Result<rhombus::Body> load_body(const RhombusSource& source, const std::vector<SfemBody>& bodies,
                                RhombusBody& made) {
  if (const auto* liver = std::get_if<PhantomLiverSurface>(&source))
    return body_of(phantom_liver(liver->detail));
  if (const auto* other = std::get_if<SurfaceOfBody>(&source)) {
    const sfem::Model& model = bodies[std::size_t(other->body)].model;
    return used_part(model.body.mesh.vertices, model.surface.triangles, made.mesh_vertex);
  }
  const SurfaceFile& file = std::get<SurfaceFile>(source);
  Result<ReadSurface> read = read_surface(file.file, file.scale);
  if (!read) return read.error();
  made.notes = read->notes;
  turn_up(read->mesh.vertices, file.up);
  return body_of(read->mesh);
}

Result<std::vector<double>> load_stiffness(const Exec& exec, const StiffnessScene& scene,
                                           const rhombus::Surface& surface, const BeginWork& begin,
                                           std::vector<std::string>& notes) {
  if (const auto* by_ct = std::get_if<CtStiffness>(&scene.source)) {
    const Result<LoadedCt> ct = load_ct(exec, by_ct->ct, begin ? begin("reading", "") : Progress());
    if (!ct) return ct.error();
    notes.insert(notes.end(), ct->notes.begin(), ct->notes.end());
    return rhombus::stiffness_below(surface, scene.depth, rhombus::factor_of_ct(ct->volume, by_ct->factors));
  }
  const auto& by_label = std::get<LabelStiffness>(scene.source);
  LabelVolume labels;
  if (by_label.phantom) {
    make_phantom(exec, *by_label.phantom, &labels, begin ? begin("painting", "") : Progress());
  } else {
    Result<LabelFile> read = read_labels(by_label.labels);
    if (!read) return read.error();
    labels = std::move(read->labels);
    if (!by_label.label_note.empty()) notes.push_back(by_label.label_note);
  }
  return rhombus::stiffness_below(surface, scene.depth, rhombus::factor_of_labels(labels, by_label.factors));
}

double enclosed_volume(const rhombus::Surface& s) {
  double sum = 0;
  for (const Int3 t : s.triangles) {
    const auto x = [&](int v) { return s.vertices[std::size_t(v)]; };
    sum += dot(x(t.x), cross(x(t.y), x(t.z))) / 6;
  }
  return sum;
}

void record_tick(RhombusBody& body, std::vector<TouchingTool>& tools, double time, double seconds) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    TouchingTool& tool = tools[std::size_t(body.tool_indices[t])];
    const rhombus::TouchForce& felt = body.forces[t];
    if (felt.slipped && tool.limits.slips++ == 0) tool.limits.slipped_at = time;
    tool.limits.yielding_ticks += felt.yielding;
    ForceSample sample{.time = time};
    sample.position = path_at(tool.path, time).position;
    sample.force = felt.force;
    sample.torque = cross(body.inputs[t].position - sample.position, felt.force);
    sample.contacts = felt.touching ? 1 : 0;
    sample.depth = felt.touching ? felt.depth : 0;
    sample.tick_seconds = float(seconds);
    if (!tool.samples.empty()) {
      const ForceSample& before = tool.samples.back();
      const double way = norm(sample.position - before.position);
      sample.path = before.path + way;
      const double moved = way + std::abs(body.inputs[t].opening - body.openings[t]);
      const double jump =
          norm(sample.force - before.force) * std::min(1.0, kJumpWay / std::max(moved, 1e-12));
      if (jump > body.jump && !felt.slipped) body.jump = jump, body.jump_at = time;
    }
    body.openings[t] = body.inputs[t].opening;
    tool.samples.push_back(sample);
  }
}

/// Jaws and grips move towards what the path says.
double next_grip(const TouchingTool& tool, double grip, bool hold) {
  const double step = kTick / (tool.forceps ? tool.closing_time : kHoldTime);
  return std::clamp(hold ? grip + step : grip - step, 0.0, 1.0);
}

}  // namespace

rhombus::TouchInput tip_input(const TouchingTool& tool, const contact::Pose& pose, double grip) {
  if (tool.forceps) return contact::touch_input(*tool.forceps, pose, grip);
  rhombus::TouchInput input{.position = pose.position, .axes = pose.axes, .grip = grip};
  if (const auto* ball = std::get_if<contact::Sphere>(&tool.tool.shape)) {
    input.radius = ball->radius;
  } else if (const auto* rod = std::get_if<contact::Capsule>(&tool.tool.shape)) {
    input.radius = rod->radius;
    input.position = contact::to_world(pose, {0, 0, -rod->half_length});
  } else {
    const contact::Shape& shape = tool.tool.shape;
    Vec3d lowest = contact::tip(shape, 0);
    for (int n = 1; n < contact::tip_count(shape); n++)
      if (const Vec3d tip = contact::tip(shape, n); tip.z < lowest.z) lowest = tip;
    input.radius = contact::tip_radius(shape);
    input.position = contact::to_world(pose, lowest + Vec3d{0, 0, input.radius});
  }
  return input;
}

Result<RhombusBody> load_rhombus(const Exec& exec, const RhombusScene& scene,
                                 const std::vector<SfemBody>& bodies, const BeginWork& begin) {
  RhombusBody body;
  body.name = scene.name;
  Result<rhombus::Body> shape = load_body(scene.source, bodies, body);
  if (!shape) return Error{fmt::format("{}: {}", scene.place, shape.error().message)};
  const Timer building;
  Result<rhombus::Model> model = rhombus::build(*shape, scene.params);
  if (!model) return Error{fmt::format("{}: {}", scene.place, model.error().message)};
  if (scene.stiffness) {
    Result<std::vector<double>> stiffness =
        load_stiffness(exec, *scene.stiffness, model->surface, begin, body.notes);
    if (!stiffness) return Error{fmt::format("{}.stiffness: {}", scene.place, stiffness.error().message)};
    shape->stiffness = std::move(*stiffness);
    model = rhombus::build(std::move(*shape), scene.params);
  }
  body.model = std::move(*model);
  body.build_seconds = building.seconds();
  body.volume = enclosed_volume(body.model.surface);
  return body;
}

RestSurface rest_surface(const RhombusBody& body) {
  return {body.model.surface.vertices, body.model.surface.triangles};
}

void begin_touch(RhombusBody& body) {
  body.state = rhombus::make_state(body.model, body.tool_indices.size());
  body.inputs.resize(body.tool_indices.size());
  body.forces.resize(body.tool_indices.size());
  body.openings.resize(body.tool_indices.size());
}

void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to) {
  if (body.tool_indices.empty()) return;
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    for (std::size_t t = 0; t < body.inputs.size(); t++) {
      const TouchingTool& tool = tools[std::size_t(body.tool_indices[t])];
      const PathRow row = path_at(tool.path, time);
      body.inputs[t] = tip_input(tool, {row.position, axes_of(row.orientation)},
                                 next_grip(tool, body.inputs[t].grip, row.hold));
    }
    const Timer timer;
    rhombus::touch(body.model, body.state, body.inputs, kTick, body.forces);
    record_tick(body, tools, time, timer.seconds());
  }
}

ShownSurface shown_surface(const Exec& exec, RhombusBody& body, const std::vector<TouchingTool>& tools,
                           double time) {
  const rhombus::StepReport report = rhombus::step(exec, body.model, body.state);
  body.pressed_volume = std::max(body.pressed_volume, report.pressed_volume);
  ShownSurface surface{.time = time};
  surface.triangles = body.model.surface.triangles;
  surface.mesh_vertex = body.mesh_vertex;
  for (const Vec3d x : body.model.surface.vertices) surface.rest.push_back(Vec3(x));
  for (const Vec3d u : body.state.displacement) surface.displacement.push_back(Vec3(u));
  surface.pressure.resize(surface.rest.size());  // the model knows forces, not how they are spread
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const TouchingTool& tool = tools[std::size_t(body.tool_indices[t])];
    const PathRow row = path_at(tool.path, time);
    surface.tools.push_back(
        {{row.position, axes_of(row.orientation)}, body.forces[t].force, body.inputs[t].opening});
  }
  return surface;
}

void remember_deepest(const Exec& exec, RhombusBody& body, const std::vector<TouchingTool>& tools,
                      double time) {
  double force = 0;
  for (const rhombus::TouchForce& felt : body.forces) force += norm(felt.force);
  if (force <= body.largest_force) return;
  body.largest_force = force;
  body.deepest = shown_surface(exec, body, tools, time);
}

}  // namespace turgor
