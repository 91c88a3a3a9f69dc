#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/io/mesh/unit_question.hpp"
#include "turgor/models/rhombus/surface_stiffness.hpp"
#include "turgor/sim/bodies/lattice/load_ct.hpp"
#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr double kJumpWay = 1e-5;  // tool displacement over which force jumps are measured [m]

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
    TURGOR_CHECK(is_index(other->body, bodies.size()), "the surface is that of a body of the world");
    SolidBoundary boundary = solid_boundary(bodies[std::size_t(other->body)].model);
    made.mesh_vertex = std::move(boundary.vertices);
    return std::move(boundary.body);
  }
  const SurfaceFile& file = std::get<SurfaceFile>(source);
  Result<ReadSurface> read = read_surface(file.file, file.scale);
  if (!read) return read.error();
  if (const Status unit = check_unit(file.file, read->mesh.vertices, file.is_scale_given); !unit)
    return unit.error();
  made.notes = read->notes;
  turn_up(read->mesh.vertices, file.up);
  return body_of(read->mesh);
}

/// Contact radius of a chain; half a unit's width for chains without tip [m].
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
    return elastic_stiffness(exec, model, solid_boundary(model), surface, contact_radius(body));
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

/// Adds a note if a tip is sharper than the model's sharpest one.
void note_sharp_tip(double radius, const std::string& tool, RhombusBody& body) {
  if (body.model.params.chain.tip == 0 || radius >= rhombus::kSharpestTip) return;
  body.notes.push_back(
      fmt::format("{}: its tip of {:.3g} mm acts as one of {:.3g} mm, the sharpest one of "
                  "rhombus chains: the force is too large",
                  tool, 1e3 * radius, 1e3 * rhombus::kSharpestTip));
}

/// Largest force jump for a small displacement of the tool or its jaws.
void measure_jump(RhombusBody& body, std::size_t t, const ForceSample& before, const ForceSample& now) {
  TURGOR_CHECK(is_index(t, body.openings.size()), "every tool has an opening");
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
  tool.limits.too_deep_ticks += haptic.too_deep;
  if (!tool.samples.empty()) measure_jump(body, t, tool.samples.back(), sample);
  body.openings[t] = body.touch.inputs[t].opening;
  tool.samples.append(sample);
}

Result<RhombusBody> load_body(const Loading& loading, const RhombusScene& scene, const World& world) {
  // facts that drawing needs
  RhombusBody body;
  body.name = scene.name;
  const Result<rhombus::Chain> chain = rhombus::build_chain(scene.params.chain);
  body.typical_force = chain ? rhombus::force_of_depth(*chain, 0.01) : 1;
  if (loading.purpose == Purpose::kDraw) return body;
  // model of the shape alone
  Result<rhombus::Body> shape = load_shape(scene.source, world.sfem_bodies, body);
  if (!shape) return Error{fmt::format("{}: {}", scene.source_location, shape.error().message)};
  const Timer building;
  Result<rhombus::Model> model = rhombus::build(*shape, scene.params);
  if (!model) return Error{fmt::format("{}: {}", scene.source_location, model.error().message)};
  // components of a file that overlap
  if (std::holds_alternative<SurfaceFile>(scene.source)) {
    const std::vector<std::string> overlaps =
        overlap_notes(loading.exec, mesh_of(model->surface.vertices, model->surface.triangles));
    body.notes.insert(body.notes.end(), overlaps.begin(), overlaps.end());
  }
  // rebuild with the elastic stiffness of each vertex
  if (scene.stiffness) {
    Result<std::vector<double>> stiffness =
        load_stiffness(loading.exec, *scene.stiffness, world.sfem_bodies, *model, loading.begin, body.notes);
    if (!stiffness)
      return Error{fmt::format("{}.stiffness: {}", scene.source_location, stiffness.error().message)};
    shape->stiffness = std::move(*stiffness);
    model = rhombus::build(std::move(*shape), scene.params);
  }
  // store model and facts
  body.model = std::move(*model);
  body.stiffness_scale = scene.stiffness_scale, body.viscosity = scene.params.viscosity;
  body.build_seconds = building.seconds();
  body.volume = enclosed_volume(body.model.surface);
  return body;
}

RestSurface rest_surface(const RhombusBody& body) {
  return {body.model.surface.vertices, body.model.surface.triangles};
}

Status begin_body(const Exec&, RhombusBody& body, const RhombusScene&, const World& world) {
  // check the number of tools
  if (body.tool_indices.size() > std::size_t(rhombus::kMaxTouches))
    return Error{fmt::format("{}: expected at most {} tools on it, found {}", body.name, rhombus::kMaxTouches,
                             body.tool_indices.size())};
  // tips and initial poses
  std::vector<contact::RhombusTip> tips;
  std::vector<contact::Pose> poses;
  for (const int t : body.tool_indices) {
    TURGOR_CHECK(is_index(t, world.tools.size()), "a body is touched by tools of its world");
    const TouchingTool& tool = world.tools[std::size_t(t)];
    tips.push_back(contact::rhombus_tip(tool.tool.shape, tool.forceps));
    note_sharp_tip(tips.back().radius, tool.name, body);
    poses.push_back(command_at(tool, 0).pose);
  }
  // initial state and first snapshot
  body.state = rhombus::make_state(body.model, tips.size());
  body.touch = contact::make_rhombus_touch(std::move(tips), poses, body.viscosity, body.texture);
  body.published = body.touch.tissue;
  contact::publish(body.touch, body.now);
  body.openings.resize(body.tool_indices.size());
  publish_tissue(body);
  return Done{};
}

void touch_body(RhombusBody& body, std::vector<TouchingTool>& tools, double from, double to) {
  if (body.tool_indices.empty()) return;
  // storage of one tick
  std::vector<contact::ToolCommand> commands(body.tool_indices.size());
  std::vector<contact::ToolReading> readings(commands.size());
  const auto tool_of = [&](std::size_t t) -> TouchingTool& {
    return tools[std::size_t(body.tool_indices[t])];
  };
  // ticks in this interval
  TURGOR_CHECK(to >= from, "ticks do not run backwards");
  const long first = std::lround(std::floor(from / kTick + 1e-9)) + 1;
  const long last = std::lround(std::floor(to / kTick + 1e-9));
  for (long tick = first; tick <= last; tick++) {
    const double time = double(tick) * kTick;
    // one tick for all tools
    for (std::size_t t = 0; t < commands.size(); t++) commands[t] = next_command(tool_of(t), time, kTick);
    const Timer timer;
    contact::tick_rhombus_touch(body.model, body.touch, commands, kTick, readings);
    const double seconds = timer.seconds();
    // log forces
    for (std::size_t t = 0; t < commands.size(); t++) {
      ForceSample sample = sample_of(time, commands[t], readings[t]);
      sample.tick_seconds = float(seconds);
      log_tick(body, t, sample, tool_of(t));
    }
  }
  // publish the last tick
  contact::publish(body.touch, body.now);
  read_touch_snapshot(body);
}

void begin_haptics(RhombusBody& body, const std::vector<TouchingTool>& /*tools*/) {
  body.haptic = std::make_unique<RhombusHaptics>();
  contact::prepare(body.touch, body.haptic->touched);
}

void tick_haptics(RhombusBody& body, std::span<const contact::ToolCommand> commands, double dt,
                  std::span<contact::ToolReading> readings) {
  TURGOR_ASSERT(body.haptic, "a haptic thread is prepared before its ticks");
  contact::tick_and_publish(body.model, body.touch, body.haptic->tissue, body.haptic->touched, commands, dt,
                            readings);
}

void publish_tissue(RhombusBody& body) {
  const contact::RhombusTissue& last = body.published;
  if (last.stiffness_scale == body.stiffness_scale && last.viscosity == body.viscosity &&
      last.waves == body.texture.waves)
    return;
  body.published = {body.stiffness_scale, body.viscosity, body.texture.waves, last.number + 1};
  if (body.haptic)
    body.haptic->tissue.write(body.published);
  else
    body.touch.tissue = body.published;
}

void queue_frame_output(RhombusBody& body) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->changes.push(body.haptic->tissue);
}

void replay_frame_output(RhombusBody& body, std::size_t /*t*/, TickInputs inputs_used) {
  TURGOR_ASSERT(body.haptic, "a replay has a haptic exchange");
  body.haptic->changes.release(inputs_used.frame, body.haptic->tissue);
}

void read_touch_snapshot(RhombusBody& body) { body.state.touches = body.now.touches; }

}  // namespace turgor
