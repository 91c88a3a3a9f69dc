#include "turgor/sim/report/report_touch.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/haptics/device_presets.hpp"
#include "turgor/sim/bodies/sfem/choose_patch.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/report/device_use.hpp"
#include "turgor/sim/report/force_error.hpp"
#include "turgor/sim/report/inclusion_marks.hpp"
#include "turgor/sim/report/missed_body.hpp"
#include "turgor/sim/report/passed_surface.hpp"
#include "turgor/sim/report/report_compare.hpp"
#include "turgor/sim/report/report_needle.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/report/trembling.hpp"

namespace turgor {

namespace {

using namespace units;

constexpr std::size_t kMostSamples = 2000;  // limit of a series; forces.csv holds every tick

struct ShapeText {
  std::string operator()(const BallTool& s) const {
    return fmt::format("sphere, radius {:.4g} mm", s.radius * kMm);
  }
  std::string operator()(const RodTool& s) const {
    return fmt::format("capsule, radius {:.4g} mm, half length {:.4g} mm", s.radius * kMm,
                       s.half_length * kMm);
  }
  std::string operator()(const MeshTool& s) const { return s.file.string(); }
  std::string operator()(const ForcepsTool& s) const {
    return fmt::format("forceps, opening {:.4g} mm", s.opening * kMm);
  }
  std::string operator()(const NeedleTool& s) const {
    return fmt::format("needle, diameter {:.4g} mm, length {:.4g} mm", s.needle.diameter * kMm,
                       s.needle.length * kMm);
  }
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

Json force_error(const ToolInput& t) {
  const std::optional<double> error = expected_force_error(t.world, t.tool);
  if (!error) return absent();
  return *error <= sfem::kForceUnknown ? Json(*error) : Json();
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
    {"force_error_expected", kPercent, "… expected error of the mesh under the tool", force_error,
     kEverywhere},
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

Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world) {
  Json json = values_of(kTool, tool_input(scene, tool, world));
  const std::size_t stride =
      std::max<std::size_t>(1, (tool.samples.size() + kMostSamples - 1) / kMostSamples);
  add_rows(json, "series_columns", "series", kForces, tool.samples, stride);
  const auto body = std::size_t(tool.body.index);
  if (tool.tool.needle)
    json["needle"] = tool.body.kind == BodyKind::kLattice ? needle_report(tool, world.lattice_bodies[body])
                                                          : needle_report(tool, world.sfem_bodies[body]);
  if (tool.body.kind == BodyKind::kSfem)
    json["over"] = over_inclusions(tool.samples, world.sfem_bodies[body].inside);
  return json;
}

Section tool_section() {
  return {"Tools", "tool", [](const Json& report) { return items_of(report, "tools"); }, captions_of(kTool),
          true};
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

namespace {

/// End of the warning about a tool that reached beyond the patch. With `patch = false`, which is a patch of
/// the body's own elements, it names none.
std::string beyond_patch_text(const World& world, const TouchingTool& tool) {
  if (tool.tool.needle)
    return ": its tip went faster than Green's functions around it were solved, and met no resistance from "
           "there on; "
           "move it more slowly";
  const SfemBody* body =
      tool.body.kind == BodyKind::kSfem ? &world.sfem_bodies[std::size_t(tool.body.index)] : nullptr;
  if (body && is_without_patch(*body))
    return fmt::format(
        ": contact is computed within {:.3g} mm of the tool, and it reached farther, where contact is "
        "ignored; patch = {{ refinement = 1, radius = … }} of body.{} may cover more",
        1e3 * body->follow.radius, body->name);
  return ": the tool reached beyond the patch, where contact is ignored; patch.radius should exceed the "
         "radius of the indentation";
}

}  // namespace

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
    else if (const std::string trembling = trembling_note(world, tool); !trembling.empty())
      warnings.push_back(trembling);
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
      warnings.push_back(tool.name + beyond_patch_text(world, tool));
  return warnings;
}

}  // namespace turgor
