#include "turgor/sim/report/report.hpp"

#include <cmath>
#include <fstream>
#include <numeric>
#include <thread>

#include <sys/utsname.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/report/report_compare.hpp"
#include "turgor/sim/report/report_rhombus.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {

namespace {

Json of_size(Int3 v) { return Json::array({v.x, v.y, v.z}); }
Json of_mm(Vec3d v) { return numbers({v.x * kMm, v.y * kMm, v.z * kMm}); }

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

Json machine_report(const Exec& exec) {
  utsname system{};
  uname(&system);
  return {{"processor", processor_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"threads", exec.threads()},
          {"system", std::string(system.sysname) + " " + system.release}};
}

std::string ct_source(const CtSource& source) { return source.phantom ? "phantom" : source.file.string(); }

Json report_body(const ReportInput&, const LatticeScene& scene, const LatticeBody& body, BodyId) {
  const lattice::Model& model = body.model;
  const std::size_t bytes = lattice::memory_bytes(model, body.state);
  const Vec3d step(model.lattice.step);
  return {{"name", body.name},
          {"model", model_name(BodyKind::kLattice)},
          {"ct",
           {{"source", ct_source(scene.ct)},
            {"size", of_size(body.ct.grid.size)},
            {"spacing_mm", of_mm(body.ct.grid.spacing)},
            {"content_hash", hash_text(body.ct_hash)}}},
          {"lattice_size", of_size(model.lattice.size)},
          {"lattice_step_mm", of_mm(step)},
          {"nodes", node_count(model.lattice)},
          {"body_nodes", model.body_nodes},
          {"free_nodes", model.free_nodes},
          {"skin_triangles", model.skin.triangles.size()},
          {"memory_bytes", bytes},
          {"memory_bytes_per_node", rounded(double(bytes) / node_count(model.lattice))},
          {"read_s", rounded(body.read_seconds)},
          {"build_s", rounded(body.build_seconds)},
          {"state_hash", hash_text(lattice::state_hash(model, body.state))}};
}

Json wound_report(const CutMeasures& cut) {
  Json profile = Json::array(), series = Json::array();
  for (const lattice::GapePoint& point : cut.wound.profile)
    profile.push_back(numbers({point.along * kMm, point.gape * kMm}));
  for (const WoundSample& s : cut.series)
    series.push_back(numbers({s.time, s.gape_max * kMm, s.gape_mean * kMm, s.opening_area * kMm2}));
  return {{"name", cut.name},
          {"body", cut.body},
          {"kind", cut.region ? "region" : "edges"},
          {"depth_mm", rounded(cut.depth * kMm)},
          {"width_mm", rounded(cut.width * kMm)},
          {cut.region ? "nodes_removed" : "edges_cut", cut.edges},
          {"angle_to_lines_deg", rounded(cut.pull.angle)},
          {"tension_across_cut_N_per_m", rounded(cut.pull.opening)},
          {"tension_along_cut_N_per_m", rounded(cut.pull.lengthwise)},
          {"length_mm", rounded(cut.wound.length * kMm)},
          {"gape_max_mm", rounded(cut.wound.gape_max * kMm)},
          {"gape_mean_mm", rounded(cut.wound.gape_mean * kMm)},
          {"opening_area_mm2", rounded(cut.wound.opening_area * kMm2)},
          {"edge_displacement_mm", rounded(cut.wound.edge_displacement * kMm)},
          {"profile_columns", {"along_mm", "gape_mm"}},
          {"profile", profile},
          {"series_columns", {"time_s", "gape_max_mm", "gape_mean_mm", "opening_area_mm2"}},
          {"series", series}};
}

Json solver_report(const Measures& measures) {
  Json samples = Json::array();
  for (const SolverSample& s : measures.solver)
    samples.push_back(numbers({s.time, s.residual.largest, s.residual.rms, s.energy, s.largest_speed}));
  return {
      {"columns", {"time_s", "residual_largest_N", "residual_rms_N", "energy_J", "largest_speed_m_per_s"}},
      {"samples", samples}};
}

Json timing_report(const Measures& measures, const RunFacts& facts) {
  const std::vector<double>& frames = measures.frame_seconds;
  const double sum = std::accumulate(frames.begin(), frames.end(), 0.0);
  Json series = Json::array();
  for (const double seconds : frames) series.push_back(rounded(seconds * kMs));
  return {{"load_s", rounded(facts.load_seconds)},
          {"simulation_s", rounded(facts.simulation_seconds)},
          {"physics_s", rounded(sum)},
          {"frames", frames.size()},
          {"frame_mean_ms", rounded(frames.empty() ? 0 : sum / double(frames.size()) * kMs)},
          {"frame_p50_ms", rounded(percentile(frames, 0.5) * kMs)},
          {"frame_p99_ms", rounded(percentile(frames, 0.99) * kMs)},
          {"frame_max_ms", rounded(percentile(frames, 1) * kMs)},
          {"frame_ms", series}};
}

Json scene_report(const Scene& scene) {
  Json json{{"file", scene.file.string()},
            {"overrides", scene.overrides},
            {"duration_s", scene.duration},
            {"frame_rate_per_s", scene.frame_rate}};
  if (scene.lattice_bodies.empty()) return json;
  const lattice::SolverParams& solver = scene.lattice_bodies[0].params.solver;
  json["method"] = solver.method == lattice::Method::kPbd ? "pbd" : "descent";
  json["sweeps"] = solver.sweeps;
  return json;
}

}  // namespace

std::string program_version() { return TURGOR_VERSION; }

Json simulation_report(const Exec& exec, const Scene& scene, const World& world, const Measures& measures,
                       const RunFacts& facts) {
  Json bodies = Json::array(), wounds = Json::array(), tools = Json::array();
  const ReportInput input{exec, world, measures};
  for_each_kind(scene, world, [&](BodyKind kind, const auto& scenes, const auto& of_kind) {
    for (std::size_t b = 0; b < of_kind.size(); b++)
      bodies.push_back(report_body(input, scenes[b], of_kind[b], BodyId{kind, int(b)}));
  });
  for (const CutMeasures& cut : measures.cuts) wounds.push_back(wound_report(cut));
  for (std::size_t t = 0; t < world.tools.size(); t++)
    tools.push_back(tool_report(scene.tools[t], world.tools[t], world));
  return {{"program", "turgor"},
          {"version", program_version()},
          {"scene", scene_report(scene)},
          {"machine", machine_report(exec)},
          {"bodies", bodies},
          {"wounds", wounds},
          {"tools", tools},
          {"profiles", profile_report(measures)},
          {"costs", cost_report(world, measures)},
          {"solver", solver_report(measures)},
          {"timing", timing_report(measures, facts)},
          {"simulated_s", rounded(time_of(world))},
          {"state_hash", hash_text(state_hash(world))},
          {"scene_text", scene.text}};
}

std::string json_text(const Json& report, int indent) {
  return report.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json bodies_of(const Json& report, BodyKind kind) {
  Json bodies = Json::array();
  for (const Json& body : report.value("bodies", Json::array()))
    if (body.value("model", "") == model_name(kind)) bodies.push_back(body);
  return bodies;
}

void add_outputs(Json& report, const RunFacts& facts) {
  Json pictures = Json::array(), deformed = Json::array();
  for (const ReportPicture& p : facts.pictures)
    pictures.push_back({{"file", p.file}, {"caption", p.caption}, {"large", p.large}});
  for (const DeformedCtReport& d : facts.deformed)
    deformed.push_back({{"body", d.body},
                        {"file", d.file},
                        {"size", of_size(d.size)},
                        {"resample_s", rounded(d.seconds)},
                        {"mass_error", rounded(d.mass_error)},
                        {"folded_tetrahedra", d.folds}});
  report["deformed_ct"] = deformed;
  report["pictures"] = pictures;
  report["files"] = facts.files;
  report["warnings"] = facts.warnings;
  report["timing"]["drawing_s"] = rounded(facts.drawing_seconds);
  report["timing"]["files_s"] = rounded(facts.file_seconds);
  report["timing"]["output_s"] = rounded(facts.output_seconds);
  report["timing"]["total_s"] = rounded(facts.total_seconds);
}

}  // namespace turgor
