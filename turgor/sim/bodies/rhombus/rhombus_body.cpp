#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/models/rhombus/surface_stiffness.hpp"
#include "turgor/sim/bodies/lattice/load_ct.hpp"
#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr double kJumpWay = 1e-5;  // forces are compared over so much of a tool's way [m]

rhombus::Body body_of(const TriMesh& mesh) {
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  return body;
}

Result<rhombus::Body> load_shape(const RhombusSource& source, const std::vector<SfemBody>& bodies,
                                 RhombusBody& made) {
  if (const auto* liver = std::get_if<PhantomLiverSurface>(&source))
    return body_of(phantom_liver(liver->detail));
  if (const auto* other = std::get_if<SurfaceOfBody>(&source)) {
    SurfacePart part = surface_part(bodies[std::size_t(other->body)].model);
    made.mesh_vertex = std::move(part.vertices);
    return std::move(part.body);
  }
  const SurfaceFile& file = std::get<SurfaceFile>(source);
  Result<ReadSurface> read = read_surface(file.file, file.scale);
  if (!read) return read.error();
  made.notes = read->notes;
  turn_up(read->mesh.vertices, file.up);
  return body_of(read->mesh);
}

/// Where a chain's tool touches; a chain that knows none is as wide as a unit [m].
double contact_radius(const rhombus::Model& model) {
  const double tip = model.params.chain.tip;
  return tip > 0 ? usual_contact(tip) : 0.5 * rhombus::unit_width(model.chain);
}

Result<std::vector<double>> load_stiffness(const Exec& exec, const StiffnessScene& scene,
                                           const std::vector<SfemBody>& bodies, const rhombus::Model& body,
                                           const BeginWork& begin, std::vector<std::string>& notes) {
  const rhombus::Surface& surface = body.surface;
  if (const auto* by_body = std::get_if<ElasticStiffness>(&scene.source)) {
    const sfem::Model& model = bodies[std::size_t(by_body->body)].model;
    return elastic_stiffness(exec, model, surface_part(model), surface, contact_radius(body));
  }
  if (const auto* by_ct = std::get_if<CtStiffness>(&scene.source)) {
    const Result<LoadedCt> ct = load_ct(exec, by_ct->ct, begin_work(begin, "reading"));
    if (!ct) return ct.error();
    notes.insert(notes.end(), ct->notes.begin(), ct->notes.end());
    return rhombus::stiffness_below(surface, scene.depth, rhombus::factor_of_ct(ct->volume, by_ct->factors));
  }
  const auto& by_label = std::get<LabelStiffness>(scene.source);
  LabelVolume labels;
  if (by_label.phantom) {
    make_phantom(exec, *by_label.phantom, &labels, begin_work(begin, "painting"));
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

/// How far the force jumps for a small way of the tool and its jaws.
void measure_jump(RhombusBody& body, std::size_t t, const ForceSample& before, const ForceSample& now) {
  const double opening = body.touch.inputs[t].opening;
  const double moved = norm(now.position - before.position) + std::abs(opening - body.openings[t]);
  const double jump = norm(now.force - before.force) * std::min(1.0, kJumpWay / std::max(moved, 1e-12));
  if (jump > body.jump && !body.touch.forces[t].slipped) body.jump = jump, body.jump_at = now.time;
}

}  // namespace

void log_tick(RhombusBody& body, std::size_t t, const ForceSample& sample, TouchingTool& tool) {
  const rhombus::TouchForce& haptic = body.touch.forces[t];
  if (haptic.slipped && tool.limits.slips++ == 0) tool.limits.slipped_at = sample.time;
  tool.limits.yielding_ticks += haptic.yielding;
  if (!tool.samples.empty()) measure_jump(body, t, tool.samples.back(), sample);
  body.openings[t] = body.touch.inputs[t].opening;
  tool.samples.append(sample);
}

Result<RhombusBody> load_body(const Loading& loading, const RhombusScene& scene, const World& world) {
  RhombusBody body;
  body.name = scene.name;
  const Result<rhombus::Chain> chain = rhombus::build_chain(scene.params.chain);
  body.usual_force = chain ? rhombus::force_of_depth(*chain, 0.01) : 1;
  if (loading.purpose == Purpose::kDraw) return body;
  Result<rhombus::Body> shape = load_shape(scene.source, world.sfem_bodies, body);
  if (!shape) return Error{fmt::format("{}: {}", scene.place, shape.error().message)};
  const Timer building;
  Result<rhombus::Model> model = rhombus::build(*shape, scene.params);
  if (!model) return Error{fmt::format("{}: {}", scene.place, model.error().message)};
  if (scene.stiffness) {
    Result<std::vector<double>> stiffness =
        load_stiffness(loading.exec, *scene.stiffness, world.sfem_bodies, *model, loading.begin, body.notes);
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

Status begin_body(const Exec&, RhombusBody& body, const RhombusScene&, const World& world) {
  if (body.tool_indices.size() > std::size_t(rhombus::kMaxTouches))
    return Error{fmt::format("{}: expected at most {} tools that touch it, found {}", body.name,
                             rhombus::kMaxTouches, body.tool_indices.size())};
  std::vector<contact::RhombusTip> tips;
  std::vector<contact::Pose> poses;
  for (const int t : body.tool_indices) {
    const TouchingTool& tool = world.tools[std::size_t(t)];
    tips.push_back(contact::rhombus_tip(tool.tool.shape, tool.forceps));
    poses.push_back(command_at(tool, 0).pose);
  }
  body.state = rhombus::make_state(body.model, tips.size());
  body.touch = contact::make_rhombus_touch(std::move(tips), poses);
  contact::publish(body.touch, body.now);
  body.openings.resize(body.tool_indices.size());
  return Done{};
}

void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to) {
  if (body.tool_indices.empty()) return;
  std::vector<contact::ToolCommand> commands(body.tool_indices.size());
  std::vector<contact::ToolReading> readings(commands.size());
  const auto tool_of = [&](std::size_t t) -> TouchingTool& {
    return tools[std::size_t(body.tool_indices[t])];
  };
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    for (std::size_t t = 0; t < commands.size(); t++) commands[t] = next_command(tool_of(t), time);
    const Timer timer;
    contact::tick(body.model, body.touch, commands, kTick, readings);
    const double seconds = timer.seconds();
    for (std::size_t t = 0; t < commands.size(); t++) {
      ForceSample sample = sample_of(time, commands[t], readings[t]);
      sample.tick_seconds = float(seconds);
      log_tick(body, t, sample, tool_of(t));
    }
  }
  contact::publish(body.touch, body.now);
  take_touched(body);
}

void begin_haptics(RhombusBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.haptic = std::make_unique<latest<contact::RhombusTouchedNow>>();
  contact::prepare(body.touch, *body.haptic);
}

void tick_haptics(RhombusBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  contact::tick(body.model, body.touch, *body.haptic, commands, dt, readings);
}

void take_touched(RhombusBody& body) { body.state.touches = body.now.touches; }

}  // namespace turgor
