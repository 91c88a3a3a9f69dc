#include "turgor/sim/bodies/lattice/lattice_body.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/contact/tick.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/sim/bodies/lattice/keep_label.hpp"
#include "turgor/sim/bodies/lattice/load_ct.hpp"
#include "turgor/sim/bodies/sfem/make_body.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// What lies beside the CT on the same patient.
struct ReadFields {
  std::optional<LabelVolume> labels;
  std::optional<VectorVolume> lines;
};
Result<ReadFields> read_fields(const LatticeScene& scene, const Grid& ct,
                               std::optional<LabelVolume> phantom_labels) {
  ReadFields fields{std::move(phantom_labels), std::nullopt};
  if (scene.given_labels) {
    fields.labels = on_grid(*scene.given_labels, ct);
    if (!fields.labels)
      return Error{
          "labels: expected a segmentation whose samples lie where those of the CT do, found another grid"};
  } else if (!scene.labels.empty()) {
    Result<LabelFile> read = read_labels_of(scene.labels, ct);
    if (!read) return read.error();
    fields.labels = std::move(read->labels);
  }
  if (!scene.direction_field.empty()) {
    Result<VectorVolume> read = read_vectors(scene.direction_field);
    if (!read) return read.error();
    fields.lines = std::move(*read);
  }
  return fields;
}

/// Fixes the nodes of the body that are held.
Status hold_nodes(const HeldBy& held, lattice::BodyNodes& nodes) {
  std::vector<Vec3d> points;
  std::vector<std::size_t> indices;
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        if (!lattice::is_body(nodes.tissue[n])) continue;
        points.push_back(point_at(nodes.grid, Vec3d(Int3{i, j, k})));
        indices.push_back(n);
      }
  const std::vector<std::uint8_t> fixed = held_points(points, held);
  for (std::size_t p = 0; p < points.size(); p++) nodes.fixed[indices[p]] |= fixed[p];
  return check_held(points, held, fixed);
}

Result<lattice::Model> build_model(const Exec& exec, const LatticeScene& scene, Int3 block,
                                   const CtVolume& ct, const ReadFields& fields) {
  lattice::Params params = scene.params;
  params.block = block;
  const bool stiffness_by_label = fields.labels && !params.tissue.young_of_label.empty();
  Result<lattice::BodyNodes> nodes =
      lattice::classify(exec, ct, stiffness_by_label ? &*fields.labels : nullptr, params);
  if (!nodes) return nodes.error();
  if (scene.held)
    if (const Status held = hold_nodes(*scene.held, *nodes); !held) return held.error();
  return lattice::assemble(exec, *nodes, fields.lines ? &*fields.lines : nullptr, params);
}

Result<LatticeBody> load(const Exec& exec, const LatticeScene& scene, const Progress& progress) {
  LatticeBody body;
  body.name = scene.name;
  body.has_gravity = scene.has_gravity;
  const Timer reading;
  Result<LoadedCt> ct = load_ct(exec, scene.ct, progress);
  if (!ct) return ct.error();
  body.ct = std::move(ct->volume);
  body.notes = std::move(ct->notes);
  body.ct_origin = std::move(ct->origin);
  if (!scene.label_note.empty()) body.notes.push_back(scene.label_note);
  const Result<ReadFields> fields = read_fields(scene, body.ct.grid, std::move(ct->labels));
  if (!fields) return fields.error();
  const Int3 block = block_of(scene, body.ct.grid);
  if (scene.only > 0) {
    const Int3 margin{2 * block.x, 2 * block.y, 2 * block.z};  // air for the surface to lie in
    const Status kept = keep_label(exec, *fields->labels, scene.only, margin, body.ct, body.notes);
    if (!kept) return kept.error();
  }
  body.ct_hash = content_hash(body.ct);
  body.read_seconds = reading.seconds();

  const Timer building;
  Result<lattice::Model> model = build_model(exec, scene, block, body.ct, *fields);
  if (!model) return model.error();
  body.model = std::move(*model);
  body.state = lattice::make_state(body.model);
  body.build_seconds = building.seconds();
  body.box = body_box(body.model);
  body.usual_force = scene.params.tissue.muscle * 1e-4;
  return body;
}

Status put_on_gpu(LatticeBody& body) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return Error{"world.device = \"gpu\": " + gpu.error().message};
  Result<std::shared_ptr<lattice::BodyBackend>> there = put(*gpu, body.model);
  if (!there) return Error{"world.device = \"gpu\": " + there.error().message};
  body.state.step_on(std::move(*there));
  const lattice::SolverParams& solver = body.model.params.solver;
  const bool may_sleep = solver.method == lattice::Method::kVbd && solver.sleep > 0;
  body.notes.push_back("steps on " + gpu->name +
                       (may_sleep ? "; no row sleeps there, whatever solver.sleep" : ""));
  return Done{};
}

void set_poses(LatticeBody& body, const std::vector<TouchingTool>& tools, double time) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const contact::ToolCommand command = command_at(tools[std::size_t(body.tool_indices[t])], time);
    body.poses[t] = {command.pose, command.hold};
  }
}

/// Those that a hand put elsewhere, to where they begin this step.
void put_tools(LatticeBody& body, const std::vector<TouchingTool>& tools, double from) {
  set_poses(body, tools, from);
  for (std::size_t t = 0; t < body.haptic.size(); t++)
    if (body.haptic[t].was_teleported) contact::teleport_tool(body.touch, body.model, int(t), body.poses[t]);
}

/// Parts of a step in each of which no tool moves farther than half of its tip.
int part_count(LatticeBody& body, const std::vector<TouchingTool>& tools, double from, double to) {
  constexpr double kWay = 0.5;
  constexpr int kMostParts = 8;
  set_poses(body, tools, from);
  const std::vector<contact::ToolPose> before = body.poses;
  set_poses(body, tools, to);
  double parts = 1;
  for (std::size_t t = 0; t < body.tools.size(); t++) {
    const contact::Shape& shape = body.tools[t].shape;
    parts = std::max(parts, contact::motion(shape, before[t].pose, body.poses[t].pose) /
                                (kWay * contact::tip_radius(shape)));
  }
  return int(std::ceil(std::min(parts, double(kMostParts))));
}

/// Of the surface at rest inside a tool, looked at in every triangle's corners, its middle and those of its
/// sides [m].
double depth_at_rest(const LatticeBody& body, const contact::Tool& tool, const contact::Pose& pose) {
  const double near = contact::bounding_radius(tool.shape);
  double deepest = 0;
  const auto read_nodes = [&](Vec3d x) {
    if (const Vec3d d = x - pose.position; dot(d, d) < near * near)
      deepest = std::max(deepest, -contact::distance(tool.shape, pose, x).distance);
  };
  for (const Int3 t : body.surface.triangles) {
    const Vec3d a = body.rest[std::size_t(t.x)], b = body.rest[std::size_t(t.y)],
                c = body.rest[std::size_t(t.z)];
    for (const Vec3d x : {a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, (a + b + c) / 3})
      read_nodes(x);
  }
  return deepest;
}

void record_step(const LatticeBody& body, std::vector<TouchingTool>& tools, double time, double seconds) {
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const contact::ToolForce& haptic = body.forces[t];
    contact::ToolReading reading{.force = haptic.force, .torque = haptic.torque, .contacts = haptic.contacts};
    if (haptic.contacts > 0) reading.depth = depth_at_rest(body, body.tools[t], body.poses[t].pose);
    ForceSample sample = sample_of(time, {.pose = body.poses[t].pose, .hold = body.poses[t].hold}, reading);
    sample.tick_seconds = float(seconds);
    tools[std::size_t(body.tool_indices[t])].samples.append(sample);
  }
}

void make_surface(LatticeBody& body) {
  body.surface = lattice::build_surface(body.model, body.state.without_places(), &body.ct);
  body.rest = lattice::rest_points(body.model, body.surface);
  body.surface_cuts = body.state.cuts();
}

}  // namespace

Int3 block_of(const LatticeScene& scene, const Grid& ct) {
  if (!(scene.step > 0)) return scene.params.block;
  const auto voxels = [&scene](double spacing) {
    return int(std::clamp(std::round(scene.step / spacing), 1.0, 64.0));
  };
  return {voxels(ct.spacing.x), voxels(ct.spacing.y), voxels(ct.spacing.z)};
}

Result<LatticeBody> load_body(const Loading& loading, const LatticeScene& scene, const World&) {
  Result<LatticeBody> body = load(loading.exec, scene, begin_work(loading.begin, "reading"));
  if (!body) return Error{fmt::format("{}: {}", scene.place, body.error().message)};
  if (scene.device == Device::kGpu && loading.purpose == Purpose::kSimulate)
    if (const Status there = put_on_gpu(*body); !there)
      return Error{fmt::format("{}: {}", scene.place, there.error().message)};
  return body;
}

void keep_surface(LatticeBody& body) {
  const bool made = !body.rest.empty();
  if (made && body.state.cuts() == body.surface_cuts) return;
  make_surface(body);
  if (made && !body.tools.empty())
    contact::take_surface(body.touch, body.model, body.state.without_places(), body.surface);
}

Status begin_body(const Exec&, LatticeBody& body, const LatticeScene&, const World& world) {
  const std::vector<TouchingTool>& tools = world.tools;
  for (const int t : body.tool_indices) body.tools.push_back(tools[std::size_t(t)].tool);
  if (body.tools.empty()) return Done{};
  body.poses.resize(body.tools.size());
  body.forces.resize(body.tools.size());
  set_poses(body, tools, 0);
  body.touch = contact::make_lattice_touch(body.model, body.state.without_places(), body.surface, body.poses);
  return Done{};
}

namespace {

/// What carries the places of the last step's contacts.
std::vector<int> touched_nodes(const LatticeBody& body) {
  std::vector<int> places;
  for (const contact::LatticeContact& contact : body.touch.contacts) places.push_back(contact.place);
  return nodes_of(body.touch, places);
}

/// What ticks feel until the next frame.
void leave_planes(LatticeBody& body) {
  if (body.haptic.empty()) return;
  body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
    for (std::size_t t = 0; t < body.haptic.size(); t++)
      leave_plane(body, t,
                  contact::local_contact(body.model, state, body.touch, int(t), body.tools[t], body.poses[t],
                                         body.haptic[t].memory));
  });
}

/// From one time to another [s].
lattice::StepReport step_lattice(const Exec& exec, LatticeBody& body, std::vector<TouchingTool>& tools,
                                 lattice::Inputs inputs, double from, double to) {
  if (body.tools.empty()) return body.state.step(exec, body.model, inputs, to - from);
  const Timer timer;
  keep_surface(body);
  put_tools(body, tools, from);
  const int parts = part_count(body, tools, from, to);
  lattice::StepReport report;
  for (int part = 1; part <= parts && report.finite; part++) {
    set_poses(body, tools, from + (to - from) * part / parts);
    const double dt = (to - from) / parts;
    const std::vector<int> near =
        contact::places_near(body.model, body.state, body.touch, body.tools, body.poses);
    body.state.read_nodes(nodes_of(body.touch, near), [&](const lattice::State& state) {
      inputs.contacts =
          contact::find_contacts(body.model, state, body.touch, body.tools, body.poses, dt, near);
    });
    const Real fastest = report.largest_speed;
    report = body.state.step(exec, body.model, inputs, dt);
    report.largest_speed = std::max(report.largest_speed, fastest);
    body.state.read_nodes(touched_nodes(body), [&](const lattice::State& state) {
      contact::read_forces(body.model, state, body.touch, body.tools, body.forces);
    });
  }
  record_step(body, tools, to, timer.seconds());
  return report;
}

}  // namespace

void step_body(const Exec& exec, LatticeBody& body, World& world, const FrameInput& input,
               FrameReport& report) {
  // Position-based dynamics has no forces that could be left over.
  const bool has_forces = body.model.params.solver.method == lattice::Method::kVbd;
  const std::vector<lattice::NodeLoad> loads = node_loads(body);
  const lattice::Inputs inputs{.gravity = body.has_gravity ? world.gravity : Vec3d{},
                               .measure_residual = input.measure_residual && has_forces,
                               .loads = loads};
  take_commands(body, input.from, input.to, world.tools);
  const lattice::StepReport done = step_lattice(exec, body, world.tools, inputs, input.from, input.to);
  // Damping takes from a speed after the way was gone.
  body.last_way =
      double(done.largest_speed) / double(speed_scale(body.model.params.solver, input.to - input.from));
  body.row_steps += done.rows, body.row_steps_asleep += done.rows_asleep;
  leave_planes(body);
  report.finite = report.finite && done.finite;
  report.largest_speed = std::max(report.largest_speed, double(done.largest_speed));
  report.residual.largest = std::max(report.residual.largest, done.residual.largest);
  report.residual.rms = std::max(report.residual.rms, done.residual.rms);
  report.residual.before = std::max(report.residual.before, done.residual.before);
}

std::uint64_t state_hash(const LatticeBody& body, std::uint64_t seed) {
  const std::uint64_t one = lattice::state_hash(body.model, body.state);
  return hash_bytes(&one, sizeof one, seed);
}

}  // namespace turgor
