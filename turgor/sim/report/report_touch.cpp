#include "turgor/sim/report/report_touch.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/haptics/device_presets.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/report/device_use.hpp"
#include "turgor/sim/report/force_error.hpp"
#include "turgor/sim/report/inclusion_marks.hpp"
#include "turgor/sim/report/missed_body.hpp"
#include "turgor/sim/report/passed_surface.hpp"
#include "turgor/sim/report/report_compare.hpp"
#include "turgor/sim/report/report_needle.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;

constexpr std::size_t kMostSamples = 2000;  // limit of a series; forces.csv holds every tick

struct SolidSourceText {
  std::string operator()(const SolidFile& s) const { return s.file.string(); }
  std::string operator()(const ClosedSurface& s) const { return s.file.string(); }
  std::string operator()(const LabeledOrgan& s) const {
    return fmt::format("label {} of {}", s.label, s.phantom ? "the phantom" : s.file.string());
  }
  std::string operator()(const HexBlock& s) const {
    return fmt::format("block of {} x {} x {} hexahedra", s.count.x, s.count.y, s.count.z);
  }
};

struct ShapeText {
  std::string operator()(const BallTool& s) const {
    return fmt::format("sphere of {:.4g} mm", s.radius * kMm);
  }
  std::string operator()(const RodTool& s) const {
    return fmt::format("capsule of {:.4g} mm, half length {:.4g} mm", s.radius * kMm, s.half_length * kMm);
  }
  std::string operator()(const MeshTool& s) const { return s.file.string(); }
  std::string operator()(const ForcepsTool& s) const {
    return fmt::format("forceps, opening {:.4g} mm", s.opening * kMm);
  }
  std::string operator()(const NeedleTool& s) const {
    return fmt::format("needle of {:.4g} mm, length {:.4g} mm", s.needle.diameter * kMm,
                       s.needle.length * kMm);
  }
};

struct SfemInput {
  const SfemScene& scene;
  const SfemBody& body;
  const Pressed& pressed;
  std::vector<double> rebuild_seconds, handover_seconds;
  double jump = 0;  // [N]
  int late =
      0;  // patches that were not ready at the tick of their handover, if ticks took their full millisecond
  int local_nodes = 0, points = 0;
  int built = 0;  // patches elsewhere, without solutions of a law
};

SfemInput sfem_input(const SfemScene& scene, const SfemBody& body, const Pressed& pressed) {
  TURGOR_CHECK(body.now.patch != nullptr, "a loaded body has a patch");
  // values of the current patch
  SfemInput input{.scene = scene,
                  .body = body,
                  .pressed = pressed,
                  .rebuild_seconds = {},
                  .handover_seconds = {},
                  .local_nodes = body.now.patch->local_nodes,
                  .points = int(body.now.patch->points.size())};
  // times and maxima over all rebuilds
  for (const PatchRebuild& r : body.rebuilds) {
    input.jump = std::max(input.jump, r.force_jump);
    if (r.is_solution) continue;
    input.built++;
    input.rebuild_seconds.push_back(r.seconds);
    input.handover_seconds.push_back(r.handover_seconds);
    input.late += r.seconds > double(kPatchTicks) * kTick;
    input.local_nodes = std::max(input.local_nodes, r.local_nodes);
    input.points = std::max(input.points, r.points);
  }
  return input;
}

using B = SfemInput;
/// Value for tetrahedra only.
Json of_tets(const SfemInput& b, double value) {
  return b.body.model.body.mesh.corners != 8 ? Json(value) : absent();
}

constexpr Unit kHertz{"Hz", "Hz"};
/// Value of a body with a nonlinear law only.
template <class V>
Json of_law(const SfemInput& b, V value) {
  return b.body.law ? Json(value) : absent();
}
/// Largest value of all tools on a textured body.
Json of_texture(const SfemInput& b, double contact::TextureState::*value) {
  if (b.body.texture.roughness <= 0) return absent();
  double most = 0;
  for (const contact::TextureState& state : b.body.now.textures) most = std::max(most, state.*value);
  return most;
}

const Quantity<B> kSfem[] = {
    {"name", kNone, "", [](const B& b) -> Json { return b.body.name; }, kInReport},
    {"model", kNone, "", [](const B&) -> Json { return model_name(BodyKind::kSfem); }, kInReport},
    {"source", kNone, "source",
     [](const B& b) -> Json { return std::visit(SolidSourceText{}, b.scene.source); }},
    {"young", kPascals, "Young's modulus", [](const B& b) -> Json { return b.scene.material.young; }},
    {"poisson", kNone, "Poisson's ratio", [](const B& b) -> Json { return b.scene.material.poisson; }},
    {"formulation", kNone, "elements",
     [](const B& b) -> Json {
       if (b.body.model.body.mesh.corners == 10) return "quadratic";
       return b.scene.formulation == sfem::Formulation::kAveraged ? "averaged" : "standard";
     }},
    {"mesh.vertices", kCount, "nodes",
     [](const B& b) -> Json { return b.body.model.body.mesh.vertices.size(); }, kEverywhere},
    {"mesh.elements", kCount, "elements of the mesh",
     [](const B& b) -> Json { return element_count(b.body.model.body.mesh); }, kEverywhere},
    {"mesh.free_nodes", kCount, "free nodes", [](const B& b) -> Json { return b.body.model.vertex.size(); }},
    {"mesh.kept_nodes", kCount, "nodes with Green's functions",
     [](const B& b) -> Json { return b.body.model.green.nodes.size(); }},
    {"mesh.surface_nodes", kCount, "", [](const B& b) -> Json { return b.body.model.green.surface_count; },
     kInReport},
    {"mesh.surface_triangles", kCount, "triangles of the surface",
     [](const B& b) -> Json { return b.body.model.surface.triangles.size(); }},
    {"mesh.volume", kMillilitres, "volume", [](const B& b) -> Json { return b.body.facts.volume; },
     kEverywhere},
    {"mesh.input_volume", kMillilitres, "",
     [](const B& b) { return b.body.facts.input_volume > 0 ? Json(b.body.facts.input_volume) : absent(); },
     kInReport},
    {"mesh.volume_error", kPercent, "volume error against the input",
     [](const B& b) {
       const SfemFacts& f = b.body.facts;
       return f.input_volume > 0 ? Json(f.volume / f.input_volume - 1) : absent();
     }},
    {"mesh.min_dihedral", kDegrees, "smallest dihedral angle",
     [](const B& b) { return of_tets(b, b.body.facts.quality.min_dihedral); }},
    {"mesh.max_dihedral", kDegrees, "largest dihedral angle",
     [](const B& b) { return of_tets(b, b.body.facts.quality.max_dihedral); }},
    {"mesh.shortest_edge", kMillimeters, "",
     [](const B& b) { return of_tets(b, b.body.facts.quality.shortest_edge); }, kInReport},
    {"mesh.longest_edge", kMillimeters, "",
     [](const B& b) { return of_tets(b, b.body.facts.quality.longest_edge); }, kInReport},
    {"green.store", kBytes, "Green's functions",
     [](const B& b) -> Json { return b.body.facts.cost.store_bytes; }, kEverywhere},
    {"green.factor", kBytes, "", [](const B& b) -> Json { return b.body.facts.cost.factor_bytes; },
     kInReport},
    {"green.on_demand", kNone, "", [](const B& b) -> Json { return b.body.facts.on_demand; }, kInReport},
    {"green.from_cache", kNone, "", [](const B& b) -> Json { return b.body.facts.from_cache; }, kInReport},
    {"green.cache_file", kNone, "", [](const B& b) -> Json { return b.body.facts.cache_file; }, kInReport},
    {"green.content_hash", kNone, "", [](const B& b) -> Json { return hash_text(b.body.facts.content_hash); },
     kInReport},
    {"green.seconds",
     {"", "s"},
     "Green's functions, computed or read in",
     [](const B& b) -> Json { return b.body.facts.green_seconds; },
     kEverywhere},
    {"memory", kBytes, "memory of the model",
     [](const B& b) -> Json { return sfem::memory_bytes(b.body.model); }},
    {"shape", kSeconds, "reading and meshing", [](const B& b) -> Json { return b.body.facts.shape_seconds; }},
    {"patch.radius", kMillimeters, "", [](const B& b) -> Json { return b.body.follow.radius; }, kInReport},
    {"patch.refinement", kCount, "", [](const B& b) -> Json { return b.body.refinement; }, kInReport},
    {"patch.local_nodes_most", kCount, "local nodes of the patch, most",
     [](const B& b) -> Json { return b.local_nodes; }, kEverywhere},
    {"patch.points_most", kCount, "", [](const B& b) -> Json { return b.points; }, kInReport},
    {"patch.rebuilds", kCount, "patches built", [](const B& b) -> Json { return b.built; }, kEverywhere},
    {"patch.rebuild_p50", kMilliseconds, "building a patch, median",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 0.5); }, kEverywhere},
    {"patch.rebuild_p99", kMilliseconds, "",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 0.99); }, kInReport},
    {"patch.rebuild_max", kMilliseconds, "building a patch, longest",
     [](const B& b) -> Json { return percentile(b.rebuild_seconds, 1); }, kEverywhere},
    {"patch.rebuilds_too_late", kCount, "patches finished too late",
     [](const B& b) -> Json { return b.late; }},
    {"patch.handover_max", kMilliseconds, "longest handover, within a tick",
     [](const B& b) -> Json { return percentile(b.handover_seconds, 1); }},
    {"patch.force_jump_max", kNewtons, "largest force jump at a handover",
     [](const B& b) -> Json { return b.jump; }, kEverywhere},
    {"patch.not_followed", kCount, "", [](const B& b) -> Json { return b.body.rejected_patches; }, kInReport},
    {"surface_strain_max", kPercent, "largest strain of the touched surface",
     [](const B& b) { return b.body.turning ? absent() : Json(b.body.surface_strain); }, kEverywhere},
    {"law.stiffening", kNone, "law of the patch, its exponent b",
     [](const B& b) { return b.body.law ? Json(b.body.law->stiffening) : absent(); }},
    {"law.solutions", kCount, "solutions of the law",
     [](const B& b) { return of_law(b, b.body.law_summary.solutions); }, kEverywhere},
    {"law.unconverged", kCount, "… not converged",
     [](const B& b) { return of_law(b, b.body.law_summary.unconverged); }},
    {"law.steps_most", kCount, "… Newton steps, most",
     [](const B& b) { return of_law(b, b.body.law_summary.most_steps); }},
    {"law.solution_mean", kMilliseconds, "… wall time, mean",
     [](const B& b) {
       const LawSummary& law = b.body.law_summary;
       return of_law(b, law.solutions > 0 ? law.seconds / law.solutions : 0);
     },
     kEverywhere},
    {"law.solution_max", kMilliseconds, "… wall time, longest",
     [](const B& b) { return of_law(b, b.body.law_summary.longest); }},
    {"law.strain_max", kPercent, "… largest strain in the patch",
     [](const B& b) { return of_law(b, b.body.law_summary.strain); }, kEverywhere},
    {"law.border_strain_max", kPercent, "… beside its border",
     [](const B& b) { return of_law(b, b.body.law_summary.border_strain); }},
    {"texture.force_max", kNewtons, "vibration by texture, largest",
     [](const B& b) { return of_texture(b, &contact::TextureState::largest_force); }, kEverywhere},
    {"texture.frequency_max", kHertz, "… largest frequency",
     [](const B& b) { return of_texture(b, &contact::TextureState::largest_rate); }},
    {"texture.limited_ticks", kCount, "… ticks in which it was limited",
     [](const B& b) -> Json {
       long ticks = 0;
       for (const contact::TextureState& state : b.body.now.textures) ticks += state.limited_ticks;
       return b.body.texture.roughness > 0 ? Json(ticks) : absent();
     }},
    {"surface_p50", kMilliseconds, "surface for a picture, median",
     [](const B& b) -> Json { return percentile(b.pressed.surface_seconds, 0.5); }},
    {"force_max", kNewtons, "", [](const B& b) -> Json { return b.pressed.force; }, kInReport},
    {"force_max_at", kSeconds, "", [](const B& b) -> Json { return b.pressed.time; }, kInReport},
    {"rotations.frames", kCount, "frames with large rotations",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->frames) : absent(); }},
    {"rotations.not_converged", kCount, "… not converged",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->unconverged) : absent(); }},
    {"rotations.residual_max", kNone, "",
     [](const B& b) { return b.body.turning ? Json(b.body.turning->largest_residual) : absent(); },
     kInReport},
};

const Quantity<PatchRebuild> kRebuilds[] = {
    {"time", kSeconds, "time", [](const PatchRebuild& r) -> Json { return r.time; }},
    {"rebuild", kMilliseconds, "wall time", [](const PatchRebuild& r) -> Json { return r.seconds; }},
    {"local_nodes", kCount, "local nodes", [](const PatchRebuild& r) -> Json { return r.local_nodes; }},
    {"force_jump", kNewtons, "jump of the force", [](const PatchRebuild& r) -> Json { return r.force_jump; }},
};

struct ToolInput {
  const ToolScene& scene;
  const TouchingTool& tool;
  const World& world;
  ForceSample most;  // with the largest force
  int contacts = 0;
  double depth = 0;     // [m]
  double inserted = 0;  // of a needle [m]
  bool beyond = false;
  DeviceUse use;
  const haptics::DevicePreset* device = nullptr;  // null: the scene names none
  std::optional<SurfacePassage> passage;
  std::vector<double>
      tick_seconds;  // without ticks that take a new patch, which belong to the patch's report
};

ToolInput tool_input(const ToolScene& scene, const TouchingTool& tool, const World& world) {
  ToolInput input{.scene = scene,
                  .tool = tool,
                  .world = world,
                  .most = {},
                  .device = haptics::find_device_preset(scene.device),
                  .passage = surface_passage(world, tool),
                  .tick_seconds = {}};
  for (const ForceSample& s : tool.samples) {
    if (norm(s.force) > norm(input.most.force)) input.most = s;
    input.contacts = std::max(input.contacts, s.contacts);
    input.depth = std::max(input.depth, s.depth);
    input.inserted = std::max(input.inserted, s.needle.inserted);
    input.beyond = input.beyond || s.beyond_patch;
    if (!s.new_patch && s.tick_seconds > 0) input.tick_seconds.push_back(s.tick_seconds);
  }
  input.use = device_use(tool.samples, input.device ? input.device->force : 0);
  return input;
}

Json expected_force_error(const ToolInput& t) {
  const auto touched = touched_elements(t.world, t.tool);
  if (!touched) return absent();
  const double error = sfem::expected_error(*touched);
  return error <= sfem::kForceUnknown ? Json(error) : Json();
}

/// Value of the haptic device that the scene names; absent without one, or if it is unknown (0).
Json of_device(const ToolInput& t, double haptics::DevicePreset::*limit) {
  return t.device && t.device->*limit > 0 ? Json(t.device->*limit) : absent();
}

/// True if forces, stiffness and reach are within all known limits.
bool fits(const haptics::DevicePreset& device, const DeviceUse& use) {
  return use.force <= device.force && use.stiffness <= device.stiffness &&
         (device.radius == 0 || use.reach <= device.radius);
}

using T = ToolInput;
const Quantity<T> kTool[] = {
    {"name", kNone, "", [](const T& t) -> Json { return t.tool.name; }, kInReport},
    {"body", kNone, "touched body",
     [](const T& t) -> Json { return touched_body(t.world, t.tool.body).name; }},
    {"shape", kNone, "shape", [](const T& t) -> Json { return std::visit(ShapeText{}, t.scene.shape); }},
    {"friction", kNone, "friction", [](const T& t) -> Json { return t.scene.friction; }},
    {"force_max", kNewtons, "largest force", [](const T& t) -> Json { return norm(t.most.force); },
     kEverywhere, "largest force on {}"},
    {"force_max_at", kSeconds, "… at", [](const T& t) -> Json { return t.most.time; }, kEverywhere},
    {"force_error_expected", kPercent, "… expected discretization error", expected_force_error, kEverywhere},
    {"stiffness_max", kTension, "largest stiffness, over a millimeter",
     [](const T& t) -> Json { return t.use.stiffness; }},
    {"reach", kMillimeters, "reach of the path to all sides", [](const T& t) -> Json { return t.use.reach; }},
    {"device.name", kNone, "haptic device",
     [](const T& t) { return t.device ? Json(t.device->name) : absent(); }, kEverywhere},
    {"device.force", kNewtons, "… its largest force",
     [](const T& t) { return of_device(t, &haptics::DevicePreset::force); }},
    {"device.stiffness", kTension, "… its largest stiffness",
     [](const T& t) { return of_device(t, &haptics::DevicePreset::stiffness); }},
    {"device.workspace", kMillimeters, "… radius of its workspace",
     [](const T& t) { return of_device(t, &haptics::DevicePreset::radius); }},
    {"device.saturated", kCount, "… forces beyond its largest",
     [](const T& t) { return t.device ? Json(t.use.saturated) : absent(); }},
    {"device.fits", kNone, "… renders this run unchanged",
     [](const T& t) { return t.device ? Json(fits(*t.device, t.use)) : absent(); }, kEverywhere},
    {"depth_max", kMillimeters, "deepest below the surface at rest",
     [](const T& t) -> Json { return t.depth; }, kEverywhere, "deepest press of {}"},
    {"contacts_max", kCount, "contact sites, most", [](const T& t) -> Json { return t.contacts; }},
    {"beyond_patch", kNone, "", [](const T& t) -> Json { return t.beyond; }, kInReport},
    {"contact_level_most", kCount, "", [](const T& t) -> Json { return t.tool.limits.coarsest; }, kInReport},
    {"contacts_dropped_ticks", kCount, "", [](const T& t) -> Json { return t.tool.limits.dropped_ticks; },
     kInReport},
    {"contacts_dropped_most", kCount, "", [](const T& t) -> Json { return t.tool.limits.dropped_most; },
     kInReport},
    {"contacts_unsolved_ticks", kCount, "", [](const T& t) -> Json { return t.tool.limits.unsolved_ticks; },
     kInReport},
    {"slips", kCount, "", [](const T& t) -> Json { return t.tool.limits.slips; }, kInReport},
    {"slipped_at", kSeconds, "", [](const T& t) -> Json { return t.tool.limits.slipped_at; }, kInReport},
    {"yielding_ticks", kCount, "", [](const T& t) -> Json { return t.tool.limits.yielding_ticks; },
     kInReport},
    {"too_deep_ticks", kCount, "", [](const T& t) -> Json { return t.tool.limits.too_deep_ticks; },
     kInReport},
    {"passed_surface_at", kSeconds, "passed through the surface, or jumped, at",
     [](const T& t) -> Json { return t.passage ? Json(t.passage->time) : absent(); }},
    {"force_every", kMilliseconds, "interval of forces",
     [](const T& t) -> Json { return force_interval(t.world, t.tool.body); }},
    {"needle_entry_force", kNewtons, "force of the first puncture",
     [](const T& t) { return t.tool.punctures > 0 ? Json(t.tool.entry_force) : absent(); }, kEverywhere,
     "force that punctures for {}"},
    {"needle_inserted_max", kMillimeters, "longest shaft in the tissue",
     [](const T& t) { return t.tool.tool.needle ? Json(t.inserted) : absent(); }, kEverywhere},
    {"ticks", kCount, "forces", [](const T& t) -> Json { return t.tool.samples.size(); }},
    {"tick_p50", kMicroseconds, "time per force, median",
     [](const T& t) -> Json { return wall_time(t.tick_seconds, 0.5); }, kEverywhere,
     "time per force of {} (median)"},
    {"tick_p99", kMicroseconds, "time per force, 99th percentile",
     [](const T& t) -> Json { return wall_time(t.tick_seconds, 0.99); }, kEverywhere,
     "time per force of {} (99th percentile)"},
    {"tick_max", kMicroseconds, "time per force, longest",
     [](const T& t) -> Json { return wall_time(t.tick_seconds, 1); }, kEverywhere},
};

using F = ForceSample;
const Quantity<F> kForces[] = {
    {"time", kSeconds, "time", [](const F& s) -> Json { return s.time; }},
    {"force", kNewtons, "force", [](const F& s) -> Json { return norm(s.force); }},
    {"depth", kMillimeters, "depth below the surface at rest", [](const F& s) -> Json { return s.depth; }},
    {"path", kMillimeters, "path of the tool", [](const F& s) -> Json { return s.path; }},
    {"contacts", kCount, "contact sites", [](const F& s) -> Json { return s.contacts; }},
    {"force_x", kNewtons, "", [](const F& s) -> Json { return s.force.x; }},
    {"force_y", kNewtons, "", [](const F& s) -> Json { return s.force.y; }},
    {"force_z", kNewtons, "", [](const F& s) -> Json { return s.force.z; }},
};

/// Warnings about forces that the model limited.
void add_limits(const TouchingTool& tool, std::vector<std::string>& warnings) {
  // contacts dropped for lack of contact sites
  const ForceLimits& limits = tool.limits;
  if (limits.dropped_ticks > 0)
    warnings.push_back(
        fmt::format("{}: in {} ms it touched more vertices than the body has contact sites, by up to {}: its "
                    "force is too "
                    "small then; raise contacts of the body",
                    tool.name, limits.dropped_ticks, limits.dropped_most));
  // grasped tissue that slipped
  if (limits.slips > 0)
    warnings.push_back(
        fmt::format("{}: grasped tissue slipped out at {:.3f} s{}: its force would exceed "
                    "the body's tear; pull less far, or raise tear",
                    tool.name, limits.slipped_at,
                    limits.slips > 1 ? fmt::format(", {} times in total", limits.slips) : ""));
  // force clamped at the tear limit
  if (limits.yielding_ticks > 0)
    warnings.push_back(
        fmt::format("{}: for {} ms its force reached the body's tear and was clamped; "
                    "larger forces are not modeled",
                    tool.name, limits.yielding_ticks));
  // press beyond the depth for which the chain is valid
  if (limits.too_deep_ticks > 0)
    warnings.push_back(
        fmt::format("{}: for {} ms it was pressed deeper than {:g} radii of its tip, where rhombus chains "
                    "are not valid; press less deep, or use a larger tip",
                    tool.name, limits.too_deep_ticks, rhombus::kDeepestPress));
}

}  // namespace

Json report_body(const ReportInput& input, const SfemScene& scene, const SfemBody& body, BodyId id) {
  Json json = values_of(kSfem, sfem_input(scene, body, pressed_body(input.measures.pressed, id)));
  add_rows(json["patch"], "series_columns", "series", kRebuilds, body.rebuilds);
  return json;
}

Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world) {
  Json json = values_of(kTool, tool_input(scene, tool, world));
  const std::size_t stride =
      std::max<std::size_t>(1, (tool.samples.size() + kMostSamples - 1) / kMostSamples);
  add_rows(json, "series_columns", "series", kForces, tool.samples, stride);
  if (tool.tool.needle) json["needle"] = needle_report(tool, world.sfem_bodies[std::size_t(tool.body.index)]);
  if (tool.body.kind == BodyKind::kSfem)
    json["over"] = over_inclusions(tool.samples, world.sfem_bodies[std::size_t(tool.body.index)].inside);
  return json;
}

Section tool_section() {
  return {"Tools", "tool", [](const Json& report) { return items_of(report, "tools"); }, captions_of(kTool),
          true};
}
Section sfem_section() {
  return {"Bodies of finite elements", "body",
          [](const Json& report) { return bodies_of(report, BodyKind::kSfem); }, captions_of(kSfem)};
}

std::vector<std::string> device_warnings(const Scene& scene, const World& world) {
  std::vector<std::string> warnings;
  for (std::size_t t = 0; t < scene.tools.size(); t++) {
    const haptics::DevicePreset* device = haptics::find_device_preset(scene.tools[t].device);
    if (!device) continue;
    const DeviceUse use = device_use(world.tools[t].samples, device->force);
    const std::string begin = fmt::format("{}: a {} ", scene.tools[t].name, device->title);
    if (use.force > device->force)
      warnings.push_back(
          fmt::format("{}reaches {:g} N and would cut off the force, which is up to {:.3g} N "
                      "and above that in {} of {} ticks",
                      begin, device->force, use.force, use.saturated, world.tools[t].samples.size()));
    if (use.stiffness > device->stiffness)
      warnings.push_back(
          fmt::format("{}renders up to {:g} N/m, and the tool feels up to {:.3g} N/m: it would feel softer",
                      begin, device->stiffness, use.stiffness));
    if (device->radius > 0 && use.reach > device->radius)
      warnings.push_back(fmt::format("{}reaches {:g} mm to all sides, and the tool moves {:.3g} mm", begin,
                                     device->radius * kMm, use.reach * kMm));
  }
  return warnings;
}

std::vector<std::string> touch_warnings(const World& world) {
  std::vector<std::string> warnings;

  // bodies
  for (const SfemBody& body : world.sfem_bodies)
    if (body.turning && body.turning->unconverged > 0)
      warnings.push_back(
          fmt::format("{}: large rotations did not converge in {} of {} frames: use a slower tool or a "
                      "higher frame "
                      "rate",
                      body.name, body.turning->unconverged, body.turning->frames));
  for (const SfemBody& body : world.sfem_bodies)
    if (body.rejected_patches > 0)
      warnings.push_back(
          fmt::format("{}: the patch did not follow the tools {} times, the previous one stayed: {}",
                      body.name, body.rejected_patches, body.rejection_reason));

  // tools
  for (const TouchingTool& tool : world.tools) {
    for (const std::string& note : tool.notes) warnings.push_back(tool.name + ": " + note);
    if (const std::string passed = passed_surface_note(world, tool); !passed.empty())
      warnings.push_back(passed);
    else if (const std::string off = missed_body_note(world, tool); !off.empty())
      warnings.push_back(off);
    add_limits(tool, warnings);
  }
  for (const TouchingTool& tool : world.tools)
    if (tool.samples.missed() > 0)
      warnings.push_back(
          fmt::format("{}: its log holds the first {} ms and lacks the last {} ms: the run exceeds "
                      "the log's limit",
                      tool.name, tool.samples.size(), tool.samples.missed()));
  for (const TouchingTool& tool : world.tools)
    if (std::any_of(tool.samples.begin(), tool.samples.end(), [](const auto& s) { return s.beyond_patch; }))
      warnings.push_back(
          fmt::format("{}: the tool reached beyond the patch, where contact is ignored; "
                      "patch.radius should exceed the radius of the indentation",
                      tool.name));
  return warnings;
}

}  // namespace turgor
