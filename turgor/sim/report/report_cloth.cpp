#include "turgor/sim/report/report_cloth.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

const char* method_name(cloth::Method method) {
  return method == cloth::Method::kJacobi      ? "jacobi"
         : method == cloth::Method::kChebyshev ? "chebyshev"
         : method == cloth::Method::kBlocks    ? "blocks"
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

using namespace units;

struct ForceAt {
  double time = 0;  // [s]
  Vec3d force;      // [N]
};
const Quantity<ForceAt> kForce[] = {
    {"time", kSeconds, "time", [](const ForceAt& f) -> Json { return f.time; }},
    {"force", kNewtons, "force", [](const ForceAt& f) -> Json { return norm(f.force); }},
};

std::vector<ForceAt> forces_over_time(const ClothBody& body, const std::vector<Vec3d>& force) {
  std::vector<ForceAt> forces;
  for (std::size_t n = 0; n < force.size(); n++) forces.push_back({body.samples[n].time, force[n]});
  return forces;
}

/// What lies on an obstacle, or pulls at a hold.
struct ImplicitContacts {
  const World& world;
  const ClothBody& body;
  const ClothObstacle* obstacle = nullptr;
  const ClothHold* hold = nullptr;
  Vec3d mean;  // force of the latest half second [N]
};

/// None without gravity.
Json weight_of(const ImplicitContacts& b, double whole) {
  const double g = norm(b.world.gravity);
  return g > 0 ? Json(dot(b.mean, b.world.gravity) / g / whole) : Json();
}
Json three(Vec3d f) { return numbers({f.x, f.y, f.z}); }

double largest_force(const ClothHold& hold) {
  double largest = 0;
  for (const Vec3d force : hold.force) largest = std::max(largest, norm(force));
  return largest;
}

/// What each obstacle bears: the force on it, and how much of the cloth's weight that is.
const Quantity<ImplicitContacts> kObstacle[] = {
    {"name", kNone, "", [](const ImplicitContacts& b) -> Json { return b.obstacle->name; }, kInReport},
    {"cloth", kNone, "cloth", [](const ImplicitContacts& b) -> Json { return b.body.name; }},
    {"kind", kNone, "kind", [](const ImplicitContacts& b) -> Json { return kind_name(*b.obstacle); }},
    {"force_N", kNone, "", [](const ImplicitContacts& b) { return three(b.mean); }, kInReport},
    {"weight", kNewtons, "weight it bears", [](const ImplicitContacts& b) { return weight_of(b, 1); },
     kEverywhere},
    {"weight_share",
     {"", "1"},
     "part of the cloth's weight",
     [](const ImplicitContacts& b) { return weight_of(b, b.body.model.total_mass * norm(b.world.gravity)); }},
};
/// What each hold takes.
const Quantity<ImplicitContacts> kHold[] = {
    {"name", kNone, "", [](const ImplicitContacts& b) -> Json { return b.hold->scene.name; }, kInReport},
    {"cloth", kNone, "cloth", [](const ImplicitContacts& b) -> Json { return b.body.name; }},
    {"vertices", kCount, "vertices",
     [](const ImplicitContacts& b) -> Json { return b.hold->vertices.size(); }},
    {"force_N", kNone, "", [](const ImplicitContacts& b) { return three(b.mean); }, kInReport},
    {"largest", kNewtons, "largest force",
     [](const ImplicitContacts& b) -> Json { return largest_force(*b.hold); }, kEverywhere},
};

const Quantity<ClothSample> kSteps[] = {
    {"time", kSeconds, "time", [](const ClothSample& s) -> Json { return s.time; }},
    {"step", kMilliseconds, "wall time", [](const ClothSample& s) -> Json { return s.seconds; }},
    {"largest_speed", kSpeed, "largest speed", [](const ClothSample& s) -> Json { return s.largest_speed; }},
    {"contacts", kCount, "contacts", [](const ClothSample& s) -> Json { return s.contacts; }},
    {"iterations", kCount, "iterations", [](const ClothSample& s) -> Json { return s.iterations; }},
};
const Quantity<ClothSample> kSnapshots[] = {
    {"time", kSeconds, "time", [](const ClothSample& s) -> Json { return s.time; }},
    {"residual_relative", kNone, "|b - W dv| / |b|", [](const ClothSample& s) -> Json { return s.residual; }},
    {"energy", kJoules, "energy", [](const ClothSample& s) -> Json { return s.energy; }},
    {"longest_spring_relative", kNone, "longest spring",
     [](const ClothSample& s) -> Json { return s.stretch; }},
};

/// Of the frames where it was measured; -1 = of none.
double largest_residual(const ClothBody& body) {
  double largest = -1;
  for (const ClothSample& s : body.samples) largest = std::max(largest, s.residual);
  return largest;
}

/// Forces that are left are a cloth that hangs and swings as another one would; "" = few are.
std::string unsettled(const ClothBody& body) {
  constexpr double kUnsettled = 0.1;
  const cloth::Solver& solver = body.model.params.solver;
  const bool stops = cloth::uses_gradients(solver.method) && solver.tolerance > 0;
  const double limit = stops ? 1.5 * solver.tolerance : kUnsettled;  // rounded off
  const auto count = std::count_if(body.samples.begin(), body.samples.end(),
                                   [limit](const ClothSample& s) { return s.residual > limit; });
  if (count == 0) return "";
  return fmt::format(
      "{}: {} sweeps or iterations left up to {:.2g} of the forces unsolved ({} frames): it moves more "
      "stiffly "
      "and slowly than its fabric; {}",
      body.name, solver.sweeps, largest_residual(body), count,
      stops ? "solver.sweeps is the most it may take" : "solver.method = \"blocks\" stops at a tolerance");
}

struct ClothPart {
  const ClothBody& body;
  Device device;
  std::size_t bytes;
  cloth::SelfDistance self;
  std::vector<double> seconds;  // of steps
};
using P = ClothPart;

const Quantity<P> kCloth[] = {
    {"name", kNone, "", [](const P& p) -> Json { return p.body.name; }, kInReport},
    {"model", kNone, "", [](const P&) -> Json { return model_name(BodyKind::kCloth); }, kInReport},
    {"vertices", kCount, "vertices", [](const P& p) -> Json { return p.body.model.count; }, kEverywhere},
    {"triangles", kCount, "triangles", [](const P& p) -> Json { return p.body.model.triangles.size(); }},
    {"springs", kCount, "springs", [](const P& p) -> Json { return p.body.model.spring_count; }, kEverywhere},
    {"parts", kCount, "", [](const P& p) -> Json { return p.body.model.part_begin.size() - 1; }, kInReport},
    {"area", kSquareMeters, "area", [](const P& p) -> Json { return p.body.model.area; }},
    {"mass", kGrams, "mass", [](const P& p) -> Json { return p.body.model.total_mass; }},
    {"mean_edge", kMillimeters, "mean edge", [](const P& p) -> Json { return p.body.model.mean_edge; }},
    {"method", kNone, "solver",
     [](const P& p) -> Json { return method_name(p.body.model.params.solver.method); }},
    {"device", kNone, "", [](const P& p) -> Json { return p.device == Device::kGpu ? "gpu" : "cpu"; },
     kInReport},
    {"sweeps", kCount, "sweeps", [](const P& p) -> Json { return p.body.model.params.solver.sweeps; }},
    {"law", kNone, "law",
     [](const P& p) -> Json {
       return p.body.model.params.fabric.law == cloth::Law::kSheet ? "sheet" : "springs";
     }},
    {"largest_residual_relative", kNone, "most of the forces that was left, |b - W dv| / |b|",
     [](const P& p) -> Json {
       const double left = largest_residual(p.body);
       return left >= 0 ? Json(left) : Json();
     }},
    {"memory_bytes_per_vertex",
     {"", "bytes/vertex"},
     "memory",
     [](const P& p) -> Json { return double(p.bytes) / p.body.model.count; },
     kEverywhere},
    {"build", kSeconds, "", [](const P& p) -> Json { return p.body.build_seconds; }, kInReport},
    {"step_p50", kMilliseconds, "a step, median",
     [](const P& p) -> Json { return percentile(p.seconds, 0.5); }, kEverywhere, "a step of {} (median)"},
    {"step_p99", kMilliseconds, "a step, 99 of 100",
     [](const P& p) -> Json { return percentile(p.seconds, 0.99); }, kEverywhere},
    {"thickness", kMillimeters, "thickness",
     [](const P& p) -> Json { return p.body.model.params.collision.thickness; }},
    {"smallest_distance", kMillimeters, "smallest distance of layers",
     [](const P& p) { return std::isfinite(p.self.smallest) ? Json(p.self.smallest) : Json(); }},
    {"pairs_too_near", kCount, "pairs nearer than 0.99 of the thickness",
     [](const P& p) -> Json { return p.self.too_near; }, kEverywhere},
    {"triangles_crossing", kCount, "pairs of triangles that cross",
     [](const P& p) -> Json { return p.self.crossings; }, kEverywhere, "crossing triangles of {}"},
    {"state_hash", kNone, "state hash",
     [](const P& p) -> Json { return hash_text(cloth::state_hash(p.body.model, p.body.state)); }},
};

/// All obstacles, or holds, of all cloths.
Json parts_of(const Json& report, const char* key) {
  Json parts = Json::array();
  for (const Json& cloth : bodies_of(report, BodyKind::kCloth))
    for (const Json& part : items_of(cloth, key)) parts.push_back(part);
  return parts;
}

}  // namespace

Json report_body(const ReportInput& input, const ClothScene& scene, const ClothBody& body, BodyId) {
  const World& world = input.world;
  ClothPart part{.body = body,
                 .device = scene.device,
                 .bytes = cloth::memory_bytes(body.model, body.state),
                 .self = cloth::self_distance(input.exec, body.model, body.state),
                 .seconds = {}};
  std::vector<ClothSample> measured;
  for (const ClothSample& s : body.samples) {
    part.seconds.push_back(s.seconds);
    if (s.is_snapshot) measured.push_back(s);
  }
  Json json = values_of(kCloth, part), obstacles = Json::array(), holds = Json::array();
  for (const ClothObstacle& o : body.obstacles) {
    obstacles.push_back(
        values_of(kObstacle, ImplicitContacts{world, body, &o, nullptr, mean_force(o.force, world.dt)}));
    add_rows(obstacles.back(), "series_columns", "series", kForce, forces_over_time(body, o.force));
  }
  for (const ClothHold& h : body.holds) {
    holds.push_back(
        values_of(kHold, ImplicitContacts{world, body, nullptr, &h, mean_force(h.force, world.dt)}));
    add_rows(holds.back(), "series_columns", "series", kForce, forces_over_time(body, h.force));
  }
  json["obstacles"] = std::move(obstacles), json["holds"] = std::move(holds);
  json["force_series_columns"] = {"time_s", "force_N"};
  add_rows(json, "series_columns", "series", kSteps, body.samples);
  add_rows(json, "snapshot_columns", "snapshots", kSnapshots, measured);
  return json;
}

Section obstacle_section() {
  return {"What cloth lies on (mean of the last half second)", "obstacle",
          [](const Json& report) { return parts_of(report, "obstacles"); }, captions_of(kObstacle)};
}
Section hold_section() {
  return {"What holds cloth", "hold", [](const Json& report) { return parts_of(report, "holds"); },
          captions_of(kHold)};
}
Section cloth_section() {
  return {"Cloth", "cloth", [](const Json& report) { return bodies_of(report, BodyKind::kCloth); },
          captions_of(kCloth)};
}

std::vector<std::string> cloth_warnings(const World& world) {
  std::vector<std::string> warnings;
  for (const ClothBody& body : world.cloth_bodies) {
    if (const std::string left = unsettled(body); !left.empty()) warnings.push_back(left);
    for (const ClothHold& hold : body.holds)
      if (!hold.missed.empty())
        warnings.push_back(
            fmt::format("{}: hold.{}: no vertex of the cloth was in its ball at {} s: it holds nothing; {}",
                        body.name, hold.scene.name, hold.scene.start, hold.missed));
  }
  return warnings;
}

namespace page {

std::string cloth_curves(const Json& report) {
  const Json cloths = bodies_of(report, BodyKind::kCloth);
  if (cloths.empty()) return "";
  constexpr SeriesKeys kForceSeries{"series_columns", "series"},
      kStepSeries = kForceSeries, kSnapshotSeries{"snapshot_columns", "snapshots"};
  Plot step{"Wall time of a step", "time [s]", "time [ms]", {}},
      contacts{"Contacts", "time [s]", "contacts", {}},
      energy{"Elastic and kinetic energy", "time [s]", "energy [J]", {}},
      residual{"Residual of the linear system", "time [s]", "|b - W dv| / |b|", {}},
      force{"Force on what the cloth lies on", "time [s]", "force [N]", {}},
      hold{"Force of what holds the cloth", "time [s]", "force [N]", {}};
  for (const Json& cloth : cloths) {
    const std::string name = cloth.at("name").get<std::string>();
    step.curves.push_back(curve_of(name, cloth, kStepSeries, "time_s", "step_ms"));
    contacts.curves.push_back(curve_of(name, cloth, kStepSeries, "time_s", "contacts"));
    energy.curves.push_back(curve_of(name, cloth, kSnapshotSeries, "time_s", "energy_J"));
    residual.curves.push_back(curve_of(name, cloth, kSnapshotSeries, "time_s", "residual_relative"));
    for (const Json& part : items_of(cloth, "obstacles"))
      force.curves.push_back(curve_of(name + " on " + part.at("name").get<std::string>(), part, kForceSeries,
                                      "time_s", "force_N"));
    for (const Json& part : items_of(cloth, "holds"))
      hold.curves.push_back(curve_of(name + " by " + part.at("name").get<std::string>(), part, kForceSeries,
                                     "time_s", "force_N"));
  }
  return "<h2>Cloth over time</h2>\n<div class=\"grid\">" + drawn(force) + drawn(hold) + drawn(energy) +
         drawn(contacts) + drawn(step) + drawn(residual) + "</div>\n";
}

}  // namespace page

}  // namespace turgor
