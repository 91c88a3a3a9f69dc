#include "turgor/sim/report/report_cloth.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/report/page.hpp"

namespace turgor {

namespace {

const char* method_name(cloth::Method method) {
  return method == cloth::Method::kJacobi      ? "jacobi"
         : method == cloth::Method::kChebyshev ? "chebyshev"
                                               : "conjugate gradients";
}

const char* kind_name(const ClothObstacle& obstacle) {
  return obstacle.support ? model_name(obstacle.support->body.kind) : "shape";
}

/// Of the latest half second [N].
Vec3d mean_force(const std::vector<Vec3d>& force, double dt) {
  const std::size_t frames = std::min(force.size(), std::size_t(std::lround(0.5 / dt)));
  Vec3d sum;
  for (std::size_t n = force.size() - frames; n < force.size(); n++) sum += force[n];
  return frames > 0 ? sum / double(frames) : sum;
}

Json force_series(const ClothBody& body, const std::vector<Vec3d>& force) {
  Json series = Json::array();
  for (std::size_t n = 0; n < force.size(); n++)
    series.push_back(numbers({body.samples[n].time, norm(force[n])}));
  return series;
}

/// What each obstacle bears: the force on it, and how much of the cloth's weight that is.
Json obstacle_report(const World& world, const ClothBody& body, const ClothObstacle& obstacle) {
  const Vec3d f = mean_force(obstacle.force, world.dt);
  const double g = norm(world.gravity);
  Json json{{"name", obstacle.name},       {"cloth", body.name},
            {"kind", kind_name(obstacle)}, {"force_N", numbers({f.x, f.y, f.z})},
            {"weight_N", nullptr},         {"weight_share", nullptr}};
  if (g > 0) {
    const double weight = dot(f, world.gravity) / g;
    json["weight_N"] = rounded(weight);
    json["weight_share"] = rounded(weight / (body.model.total_mass * g));
  }
  json["series"] = force_series(body, obstacle.force);
  return json;
}

/// What each hold takes.
Json hold_report(const World& world, const ClothBody& body, const ClothHold& hold) {
  const Vec3d f = mean_force(hold.force, world.dt);
  double largest = 0;
  for (const Vec3d force : hold.force) largest = std::max(largest, norm(force));
  return {{"name", hold.scene.name},          {"cloth", body.name},
          {"vertices", hold.vertices.size()}, {"force_N", numbers({f.x, f.y, f.z})},
          {"largest_N", rounded(largest)},    {"series", force_series(body, hold.force)}};
}

}  // namespace

Json report_body(const ReportInput& input, const ClothScene&, const ClothBody& body, BodyId) {
  const World& world = input.world;
  const cloth::Model& model = body.model;
  const cloth::Params& params = model.params;
  const std::size_t bytes = cloth::memory_bytes(model, body.state);
  const cloth::SelfDistance self = cloth::self_distance(input.exec, model, body.state);
  std::vector<double> seconds;
  Json series = Json::array(), snapshots = Json::array(), obstacles = Json::array(), holds = Json::array();
  for (const ClothSample& s : body.samples) {
    seconds.push_back(s.seconds);
    series.push_back(numbers({s.time, s.seconds * kMs, s.largest_speed, double(s.contacts)}));
    if (s.residual >= 0) snapshots.push_back(numbers({s.time, s.residual, s.energy, s.stretch}));
  }
  for (const ClothObstacle& o : body.obstacles) obstacles.push_back(obstacle_report(world, body, o));
  for (const ClothHold& hold : body.holds) holds.push_back(hold_report(world, body, hold));
  Json json{{"name", body.name},
            {"model", model_name(BodyKind::kCloth)},
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
            {"holds", holds},
            {"force_series_columns", {"time_s", "force_N"}},
            {"series_columns", {"time_s", "step_ms", "largest_speed_m_per_s", "contacts"}},
            {"series", series},
            {"snapshot_columns", {"time_s", "residual_relative", "energy_J", "longest_spring_relative"}},
            {"snapshots", snapshots},
            {"state_hash", hash_text(cloth::state_hash(model, body.state))}};
  if (std::isfinite(self.smallest)) json["smallest_distance_mm"] = rounded(self.smallest * kMm);
  return json;
}

std::vector<std::string> cloth_warnings(const World& world) {
  std::vector<std::string> warnings;
  for (const ClothBody& body : world.cloth_bodies)
    for (const ClothHold& hold : body.holds)
      if (!hold.missed.empty())
        warnings.push_back(
            fmt::format("{}: hold.{}: no vertex of the cloth was in its ball at {} s: it holds nothing; {}",
                        body.name, hold.scene.name, hold.scene.start, hold.missed));
  return warnings;
}

namespace page {

std::string cloth_figures(const Json& report) {
  std::string html;
  for (const Json& cloth : bodies_of(report, BodyKind::kCloth))
    html +=
        key_figure(shown(cloth.at("step_p50_ms")) + " ms",
                   "a step of " + shown(cloth.at("name")) + " (median)") +
        key_figure(shown(cloth.at("triangles_crossing")), "crossing triangles of " + shown(cloth.at("name")));
  return html;
}

std::string cloth_curves(const Json& report) {
  const Json clothes = bodies_of(report, BodyKind::kCloth);
  if (clothes.empty()) return "";
  Plot step{"Wall time of a step", "time [s]", "time [ms]", {}},
      contacts{"Contacts", "time [s]", "contacts", {}},
      energy{"Elastic and kinetic energy", "time [s]", "energy [J]", {}},
      residual{"Residual of the linear system", "time [s]", "|b - W dv| / |b|", {}},
      force{"Force on what the cloth lies on", "time [s]", "force [N]", {}},
      hold{"Force of what holds the cloth", "time [s]", "force [N]", {}};
  for (const Json& cloth : clothes) {
    const std::string name = cloth.at("name").get<std::string>();
    step.curves.push_back(curve_of(name, cloth.at("series"), 0, 1));
    contacts.curves.push_back(curve_of(name, cloth.at("series"), 0, 3));
    energy.curves.push_back(curve_of(name, cloth.at("snapshots"), 0, 2));
    residual.curves.push_back(curve_of(name, cloth.at("snapshots"), 0, 1));
    for (const Json& obstacle : cloth.at("obstacles"))
      force.curves.push_back(
          curve_of(name + " on " + obstacle.at("name").get<std::string>(), obstacle.at("series"), 0, 1));
    for (const Json& one : cloth.at("holds"))
      hold.curves.push_back(
          curve_of(name + " by " + one.at("name").get<std::string>(), one.at("series"), 0, 1));
  }
  return "<h2>Cloth over time</h2>\n<div class=\"grid\">" + drawn(force) + drawn(hold) + drawn(energy) +
         drawn(contacts) + drawn(step) + drawn(residual) + "</div>\n";
}

std::string cloth_tables(const Json& report) {
  const Json clothes = bodies_of(report, BodyKind::kCloth);
  if (clothes.empty()) return "";
  Json obstacles = Json::array(), holds = Json::array();
  for (const Json& cloth : clothes) {
    for (const Json& obstacle : cloth.at("obstacles")) obstacles.push_back(obstacle);
    for (const Json& hold : cloth.at("holds")) holds.push_back(hold);
  }
  std::string lies_on;
  if (!obstacles.empty())
    lies_on = "<h2>What cloth lies on (mean of the last half second)</h2>\n" +
              quantity_table(obstacles, "obstacle",
                             {{"cloth", "cloth"},
                              {"kind", "kind"},
                              {"weight_N", "weight it bears [N]"},
                              {"weight_share", "part of the cloth's weight [1]"}});
  if (!holds.empty())
    lies_on +=
        "<h2>What holds cloth</h2>\n" +
        quantity_table(holds, "hold",
                       {{"cloth", "cloth"}, {"vertices", "vertices"}, {"largest_N", "largest force [N]"}});
  return lies_on + "<h2>Cloth</h2>\n" +
         quantity_table(clothes, "cloth",
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
