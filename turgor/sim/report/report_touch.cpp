#include "turgor/sim/report/report_touch.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/report/off_the_body.hpp"
#include "turgor/sim/report/report_compare.hpp"

namespace turgor {

namespace {

constexpr double kMicro = 1e6;
constexpr std::size_t kMostRows = 2000;  // of a series; every tick is in forces.csv

struct SourceText {
  std::string operator()(const SolidFile& s) const { return s.file.string(); }
  std::string operator()(const ClosedSurface& s) const { return s.file.string(); }
  std::string operator()(const LabelledOrgan& s) const {
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
};

Json mesh_report(const SfemBody& body) {
  const MeshQuality& q = body.facts.quality;
  Json mesh{{"vertices", body.model.body.mesh.vertices.size()},
            {"elements", element_count(body.model.body.mesh)},
            {"free_nodes", body.model.vertex.size()},
            {"kept_nodes", body.model.green.nodes.size()},
            {"surface_nodes", body.model.green.surface_count},
            {"surface_triangles", body.model.surface.triangles.size()},
            {"volume_ml", rounded(body.facts.volume * 1e6)}};
  if (body.facts.input_volume > 0) {
    mesh["input_volume_ml"] = rounded(body.facts.input_volume * 1e6);
    mesh["volume_error_percent"] = rounded(100 * (body.facts.volume / body.facts.input_volume - 1));
  }
  if (body.model.body.mesh.corners == 4)
    mesh.update({{"min_dihedral_deg", rounded(q.min_dihedral)},
                 {"max_dihedral_deg", rounded(q.max_dihedral)},
                 {"shortest_edge_mm", rounded(q.shortest_edge * kMm)},
                 {"longest_edge_mm", rounded(q.longest_edge * kMm)}});
  return mesh;
}

Json patch_report(const SfemScene& scene, const SfemBody& body) {
  std::vector<double> seconds, handovers;
  double jump = 0;
  int late = 0;  // not ready at the tick that takes it, were a tick to last its millisecond
  int local = body.now.patch->local_nodes, points = int(body.now.patch->points.size());
  Json series = Json::array();
  for (const PatchRebuild& r : body.rebuilds) {
    seconds.push_back(r.seconds);
    handovers.push_back(r.handover_seconds);
    jump = std::max(jump, r.force_jump);
    late += r.seconds > double(kPatchTicks) * kTick;
    local = std::max(local, r.local_nodes), points = std::max(points, r.points);
    series.push_back(numbers({r.time, r.seconds * kMs, double(r.local_nodes), r.force_jump}));
  }
  return {{"radius_mm", rounded(scene.patch.radius * kMm)},
          {"refinement", scene.patch.refinement},
          {"local_nodes_most", local},
          {"points_most", points},
          {"rebuilds", body.rebuilds.size()},
          {"rebuild_p50_ms", rounded(percentile(seconds, 0.5) * kMs)},
          {"rebuild_p99_ms", rounded(percentile(seconds, 0.99) * kMs)},
          {"rebuild_max_ms", rounded(percentile(seconds, 1) * kMs)},
          {"rebuilds_too_late", late},
          {"handover_max_ms", rounded(percentile(handovers, 1) * kMs)},
          {"force_jump_max_N", rounded(jump)},
          {"not_followed", body.kept_patches},
          {"series_columns", {"time_s", "rebuild_ms", "local_nodes", "force_jump_N"}},
          {"series", series}};
}

/// Wall times of ticks, those with a new patch left out: they are in the patch's part.
std::vector<double> plain_tick_seconds(const TouchingTool& tool) {
  std::vector<double> seconds;
  for (const ForceSample& s : tool.samples)
    if (!s.new_patch) seconds.push_back(s.tick_seconds);
  return seconds;
}

Json series_report(const TouchingTool& tool) {
  Json series = Json::array();
  const std::size_t stride = std::max<std::size_t>(1, (tool.samples.size() + kMostRows - 1) / kMostRows);
  for (std::size_t i = 0; i < tool.samples.size(); i += stride) {
    const ForceSample& s = tool.samples[i];
    series.push_back(numbers({s.time, norm(s.force), s.depth * kMm, s.path * kMm, double(s.contacts),
                              s.force.x, s.force.y, s.force.z}));
  }
  return series;
}

/// What a tool asked that its body did not give.
void add_limits(const TouchingTool& tool, std::vector<std::string>& warnings) {
  const ForceLimits& limits = tool.limits;
  if (limits.dropped_ticks > 0)
    warnings.push_back(fmt::format(
        "{}: in {} ms it touched more places than are solved for, in the worst by {}: its force is too "
        "small there; raise contacts of the body",
        tool.name, limits.dropped_ticks, limits.dropped_most));
  if (limits.slips > 0)
    warnings.push_back(
        fmt::format("{}: what it held slipped out of it at {:.3f} s{}: it would have borne more than "
                    "the body's tear; pull less far, or raise tear",
                    tool.name, limits.slipped_at,
                    limits.slips > 1 ? fmt::format(", {} times in all", limits.slips) : ""));
  if (limits.yielding_ticks > 0)
    warnings.push_back(
        fmt::format("{}: for {} ms it pressed harder than the body's tear: the force stays there, "
                    "what is behind it is not known",
                    tool.name, limits.yielding_ticks));
}

}  // namespace

Json report_body(const ReportInput& input, const SfemScene& scene, const SfemBody& body, BodyId id) {
  const Pressed& pressed = pressed_body(input.measures.pressed, id);
  const SfemFacts& facts = body.facts;
  const bool averaged = scene.formulation == sfem::Formulation::kAveraged;
  Json json{{"name", body.name},
            {"model", model_name(BodyKind::kSfem)},
            {"source", std::visit(SourceText{}, scene.source)},
            {"young_Pa", rounded(scene.material.young)},
            {"poisson", rounded(scene.material.poisson)},
            {"formulation", averaged ? "averaged" : "standard"},
            {"mesh", mesh_report(body)},
            {"green",
             {{"store_bytes", facts.cost.store_bytes},
              {"factor_bytes", facts.cost.factor_bytes},
              {"on_demand", facts.on_demand},
              {"from_cache", facts.from_cache},
              {"cache_file", facts.cache_file},
              {"content_hash", hash_text(facts.content_hash)},
              {"seconds", rounded(facts.green_seconds)}}},
            {"shape_s", rounded(facts.shape_seconds)},
            {"patch", patch_report(scene, body)},
            {"surface_p50_ms", rounded(percentile(pressed.surface_seconds, 0.5) * kMs)},
            {"force_max_N", rounded(pressed.force)},
            {"force_max_at_s", rounded(pressed.time)}};
  if (const auto& turning = body.turning)
    json["rotations"] = {{"frames", turning->frames},
                         {"not_converged", turning->unconverged},
                         {"residual_max", rounded(turning->largest_residual)}};
  return json;
}

Json tool_report(const ToolScene& scene, const TouchingTool& tool, const World& world) {
  ForceSample most;
  int contacts = 0;
  double depth = 0;
  bool beyond = false;
  for (const ForceSample& s : tool.samples) {
    if (norm(s.force) > norm(most.force)) most = s;
    contacts = std::max(contacts, s.contacts);
    depth = std::max(depth, s.depth);
    beyond = beyond || s.beyond_patch;
  }
  const std::vector<double> ticks = plain_tick_seconds(tool);
  return {{"name", tool.name},
          {"body", touched_body(world, tool.body).name},
          {"shape", std::visit(ShapeText{}, scene.shape)},
          {"friction", rounded(scene.friction)},
          {"force_max_N", rounded(norm(most.force))},
          {"force_max_at_s", rounded(most.time)},
          {"depth_max_mm", rounded(depth * kMm)},
          {"contacts_max", contacts},
          {"beyond_patch", beyond},
          {"contact_level_most", tool.limits.coarsest},
          {"contacts_dropped_ticks", tool.limits.dropped_ticks},
          {"contacts_dropped_most", tool.limits.dropped_most},
          {"slips", tool.limits.slips},
          {"slipped_at_s", rounded(tool.limits.slipped_at)},
          {"yielding_ticks", tool.limits.yielding_ticks},
          {"force_every_ms", rounded(force_interval(world, tool.body) * kMs)},
          {"ticks", tool.samples.size()},
          {"tick_p50_us", rounded(percentile(ticks, 0.5) * kMicro)},
          {"tick_p99_us", rounded(percentile(ticks, 0.99) * kMicro)},
          {"tick_max_us", rounded(percentile(ticks, 1) * kMicro)},
          {"series_columns",
           {"time_s", "force_N", "depth_mm", "path_mm", "contacts", "force_x_N", "force_y_N", "force_z_N"}},
          {"series", series_report(tool)}};
}

std::vector<std::string> touch_warnings(const World& world) {
  std::vector<std::string> warnings;
  for (const SfemBody& body : world.sfem_bodies)
    if (body.turning && body.turning->unconverged > 0)
      warnings.push_back(
          fmt::format("{}: large rotations were not solved to the end in {} of {} frames: a slower tool or a "
                      "higher frame "
                      "rate gives them time",
                      body.name, body.turning->unconverged, body.turning->frames));
  for (const SfemBody& body : world.sfem_bodies)
    if (body.kept_patches > 0)
      warnings.push_back(
          fmt::format("{}: the patch did not follow the tools {} times, the one before stayed: {}", body.name,
                      body.kept_patches, body.kept_because));
  for (const TouchingTool& tool : world.tools) {
    for (const std::string& note : tool.notes) warnings.push_back(tool.name + ": " + note);
    if (const std::string off = off_the_body(world, tool); !off.empty()) warnings.push_back(off);
    add_limits(tool, warnings);
  }
  for (const TouchingTool& tool : world.tools)
    if (tool.samples.missed() > 0)
      warnings.push_back(
          fmt::format("{}: its first {} ms were kept, the {} ms behind them were not: a run that long has no "
                      "room for all",
                      tool.name, tool.samples.size(), tool.samples.missed()));
  for (const TouchingTool& tool : world.tools)
    if (std::any_of(tool.samples.begin(), tool.samples.end(), [](const auto& s) { return s.beyond_patch; }))
      warnings.push_back(
          fmt::format("{}: the tool reached beyond the patch, where the body does not feel it; "
                      "patch.radius should be larger than what it presses in",
                      tool.name));
  return warnings;
}

}  // namespace turgor
