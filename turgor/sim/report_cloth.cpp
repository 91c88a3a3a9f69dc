#include "turgor/sim/report_cloth.hpp"

#include <algorithm>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/json_numbers.hpp"
#include "turgor/sim/page.hpp"

namespace turgor {

namespace {

const char* method_name(cloth::Method method) {
  return method == cloth::Method::kJacobi      ? "jacobi"
         : method == cloth::Method::kChebyshev ? "chebyshev"
                                               : "conjugate gradients";
}

}  // namespace

Json cloth_report(const Exec& exec, const ClothBody& body) {
  const cloth::Model& model = body.model;
  const cloth::Params& params = model.params;
  const std::size_t bytes = cloth::memory_bytes(model, body.state);
  const cloth::SelfDistance self = cloth::self_distance(exec, model, body.state);
  std::vector<double> seconds;
  Json series = Json::array(), snapshots = Json::array(), obstacles = Json::array();
  for (const ClothSample& s : body.samples) {
    seconds.push_back(s.seconds);
    series.push_back(numbers({s.time, s.seconds * kMs, s.largest_speed, double(s.contacts)}));
    if (s.residual >= 0) snapshots.push_back(numbers({s.time, s.residual, s.energy, s.stretch}));
  }
  for (const ClothObstacle& o : body.obstacles)
    obstacles.push_back({{"name", o.name}, {"force_N", numbers({o.force.x, o.force.y, o.force.z})}});
  Json json{{"name", body.name},
            {"vertices", model.count},
            {"triangles", model.triangles.size()},
            {"springs", model.spring_count},
            {"parts", model.part_begin.size() - 1},
            {"area_m2", rounded(model.area)},
            {"mass_g", rounded(model.total_mass * 1e3)},
            {"mean_edge_mm", rounded(model.mean_edge * kMm)},
            {"method", method_name(params.solver.method)},
            {"sweeps", params.solver.sweeps},
            {"memory_bytes_per_vertex", rounded(double(bytes) / model.count)},
            {"build_s", rounded(body.build_seconds)},
            {"step_p50_ms", rounded(percentile(seconds, 0.5) * kMs)},
            {"step_p99_ms", rounded(percentile(seconds, 0.99) * kMs)},
            {"thickness_mm", rounded(params.collision.thickness * kMm)},
            {"smallest_distance_mm", nullptr},
            {"pairs_too_near", self.too_near},
            {"triangles_crossing", self.crossings},
            {"obstacles", obstacles},
            {"series_columns", {"time_s", "step_ms", "largest_speed_m_per_s", "contacts"}},
            {"series", series},
            {"snapshot_columns", {"time_s", "residual_relative", "energy_J", "longest_spring_relative"}},
            {"snapshots", snapshots},
            {"state_hash", hash_text(cloth::state_hash(model, body.state))}};
  if (std::isfinite(self.smallest)) json["smallest_distance_mm"] = rounded(self.smallest * kMm);
  return json;
}

std::uint64_t cloth_hash(const World& world, std::uint64_t seed) {
  for (const ClothBody& body : world.clothes) {
    const std::uint64_t one = cloth::state_hash(body.model, body.state);
    seed = hash_bytes(&one, sizeof one, seed);
  }
  return seed;
}

namespace page {

std::string cloth_figures(const Json& report) {
  std::string html;
  for (const Json& cloth : report.value("clothes", Json::array()))
    html +=
        key_figure(shown(cloth.at("step_p50_ms")) + " ms",
                   "a step of " + shown(cloth.at("name")) + " (median)") +
        key_figure(shown(cloth.at("triangles_crossing")), "crossing triangles of " + shown(cloth.at("name")));
  return html;
}

std::string cloth_curves(const Json& report, const std::filesystem::path& folder) {
  const Json clothes = report.value("clothes", Json::array());
  if (clothes.empty()) return "";
  Plot step{"Wall time of a step", "time [s]", "time [ms]", {}},
      contacts{"Contacts", "time [s]", "contacts", {}},
      energy{"Elastic and kinetic energy", "time [s]", "energy [J]", {}},
      residual{"Residual of the linear system", "time [s]", "|b - W dv| / |b|", {}};
  for (const Json& cloth : clothes) {
    const std::string name = cloth.at("name").get<std::string>();
    step.curves.push_back(curve_of(name, cloth.at("series"), 0, 1));
    contacts.curves.push_back(curve_of(name, cloth.at("series"), 0, 3));
    energy.curves.push_back(curve_of(name, cloth.at("snapshots"), 0, 2));
    residual.curves.push_back(curve_of(name, cloth.at("snapshots"), 0, 1));
  }
  return "<h2>Cloth over time</h2>\n<div class=\"grid\">" + drawn(energy, folder) + drawn(contacts, folder) +
         drawn(step, folder) + drawn(residual, folder) + "</div>\n";
}

std::string cloth_tables(const Json& report) {
  const Json clothes = report.value("clothes", Json::array());
  if (clothes.empty()) return "";
  return "<h2>Cloth</h2>\n" + quantity_table(clothes, "cloth",
                                             {{"vertices", "vertices"},
                                              {"triangles", "triangles"},
                                              {"springs", "springs"},
                                              {"area_m2", "area [m²]"},
                                              {"mass_g", "mass [g]"},
                                              {"mean_edge_mm", "mean edge [mm]"},
                                              {"method", "solver"},
                                              {"sweeps", "sweeps"},
                                              {"memory_bytes_per_vertex", "memory [bytes/vertex]"},
                                              {"step_p50_ms", "a step, median [ms]"},
                                              {"step_p99_ms", "a step, 99 of 100 [ms]"},
                                              {"thickness_mm", "thickness [mm]"},
                                              {"smallest_distance_mm", "smallest distance of layers [mm]"},
                                              {"pairs_too_near", "pairs nearer than 0.99 of the thickness"},
                                              {"triangles_crossing", "pairs of triangles that cross"},
                                              {"state_hash", "state hash"}});
}

}  // namespace page

}  // namespace turgor
