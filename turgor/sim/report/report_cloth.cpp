#include "turgor/sim/report/report_cloth.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/bodies/cloth/free_support.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

const char* method_name(cloth::Method method) {
  return method == cloth::Method::kJacobi      ? "jacobi"
         : method == cloth::Method::kChebyshev ? "chebyshev"
         : method == cloth::Method::kTwoLevel  ? "two_level"
                                               : "conjugate gradients";
}

const char* kind_name(const ClothObstacle& obstacle) {
  return obstacle.support ? model_name(obstacle.support->body.kind) : "shape";
}

/// Mean over the latest half second [N].
Vec3d mean_force(const std::vector<Vec3d>& force, double dt) {
  TURGOR_CHECK(is_step_length(dt), "a frame has a positive length");
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
  TURGOR_CHECK(force.size() <= body.samples.size(), "every force belongs to a recorded step");
  std::vector<ForceAt> forces;
  for (std::size_t n = 0; n < force.size(); n++) forces.push_back({body.samples[n].time, force[n]});
  return forces;
}

/// Force on an obstacle or a hold.
struct ClothForce {
  const World& world;
  const ClothBody& body;
  const ClothObstacle* obstacle = nullptr;
  const ClothHold* hold = nullptr;
  Vec3d mean;  // mean over the latest half second [N]
};

/// Null without gravity.
Json weight_of(const ClothForce& b, double whole) {
  const double g = norm(b.world.gravity);
  return g > 0 ? Json(dot(b.mean, b.world.gravity) / g / whole) : Json();
}
Json three(Vec3d f) { return numbers({f.x, f.y, f.z}); }

double largest_force(const ClothHold& hold) {
  double largest = 0;
  for (const Vec3d force : hold.force) largest = std::max(largest, norm(force));
  return largest;
}

/// Force on each obstacle, and the supported fraction of the cloth's weight.
const Quantity<ClothForce> kObstacle[] = {
    {"name", kNone, "", [](const ClothForce& b) -> Json { return b.obstacle->name; }, kInReport},
    {"cloth", kNone, "cloth", [](const ClothForce& b) -> Json { return b.body.name; }},
    {"kind", kNone, "kind", [](const ClothForce& b) -> Json { return kind_name(*b.obstacle); }},
    {"force_N", kNone, "", [](const ClothForce& b) { return three(b.mean); }, kInReport},
    {"weight", kNewtons, "supported weight", [](const ClothForce& b) { return weight_of(b, 1); },
     kEverywhere},
    {"weight_share",
     {"", "1"},
     "fraction of the cloth's weight",
     [](const ClothForce& b) { return weight_of(b, b.body.model.total_mass * norm(b.world.gravity)); }},
};
/// Force on each hold.
const Quantity<ClothForce> kHold[] = {
    {"name", kNone, "", [](const ClothForce& b) -> Json { return b.hold->scene.name; }, kInReport},
    {"cloth", kNone, "cloth", [](const ClothForce& b) -> Json { return b.body.name; }},
    {"vertices", kCount, "vertices", [](const ClothForce& b) -> Json { return b.hold->vertices.size(); }},
    {"force_N", kNone, "", [](const ClothForce& b) { return three(b.mean); }, kInReport},
    {"largest", kNewtons, "largest force", [](const ClothForce& b) -> Json { return largest_force(*b.hold); },
     kEverywhere},
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

/// Largest measured residual; -1 = not measured.
double largest_residual(const ClothBody& body) {
  double largest = -1;
  for (const ClothSample& s : body.samples) largest = std::max(largest, s.residual);
  return largest;
}

/// Warning about a large residual; "" if it is small.
std::string residual_warning(const ClothBody& body) {
  constexpr double kUnsettled = 0.1;
  const cloth::Solver& solver = body.model.params.solver;
  const bool stops = cloth::uses_conjugate_gradients(solver.method) && solver.tolerance > 0;
  const double limit = stops ? 1.5 * solver.tolerance : kUnsettled;  // allows for rounding
  const auto count = std::count_if(body.samples.begin(), body.samples.end(),
                                   [limit](const ClothSample& s) { return s.residual > limit; });
  if (count == 0) return "";
  return fmt::format(
      "{}: {} sweeps or iterations left a relative residual of up to {:.2g} ({} frames): it moves more "
      "stiffly and slowly than its fabric; {}",
      body.name, solver.sweeps, largest_residual(body), count,
      stops ? "solver.sweeps is the limit of iterations"
            : "solver.method = \"two_level\" stops at a tolerance");
}

struct ClothInput {
  const ClothBody& body;
  std::size_t bytes;
  cloth::SelfDistance self;
  std::vector<double> seconds;  // of steps
};
using P = ClothInput;

const Quantity<P> kCloth[] = {
    {"name", kNone, "", [](const P& p) -> Json { return p.body.name; }, kInReport},
    {"model", kNone, "", [](const P&) -> Json { return model_name(BodyKind::kCloth); }, kInReport},
    {"vertices", kCount, "vertices", [](const P& p) -> Json { return p.body.model.count; }, kEverywhere},
    {"triangles", kCount, "triangles", [](const P& p) -> Json { return p.body.model.triangles.size(); }},
    {"springs", kCount, "springs", [](const P& p) -> Json { return p.body.model.spring_count; }, kEverywhere},
    {"components", kCount, "", [](const P& p) -> Json { return p.body.model.component_begin.size() - 1; },
     kInReport},
    {"area", kSquareMeters, "area", [](const P& p) -> Json { return p.body.model.area; }},
    {"mass", kGrams, "mass", [](const P& p) -> Json { return p.body.model.total_mass; }},
    {"mean_edge", kMillimeters, "mean edge", [](const P& p) -> Json { return p.body.model.mean_edge; }},
    {"method", kNone, "solver",
     [](const P& p) -> Json { return method_name(p.body.model.params.solver.method); }},
    {"device", kNone, "", [](const P& p) -> Json { return p.body.state.has_device() ? "gpu" : "cpu"; },
     kInReport},
    {"sweeps", kCount, "sweeps", [](const P& p) -> Json { return p.body.model.params.solver.sweeps; }},
    {"law", kNone, "law",
     [](const P& p) -> Json {
       return p.body.model.params.fabric.law == cloth::Law::kSheet ? "sheet" : "springs";
     }},
    {"largest_residual_relative", kNone, "largest relative residual, |b - W dv| / |b|",
     [](const P& p) -> Json {
       const double residual = largest_residual(p.body);
       return residual >= 0 ? Json(residual) : Json();
     }},
    {"memory_bytes_per_vertex",
     {"", "bytes/vertex"},
     "memory",
     [](const P& p) -> Json { return double(p.bytes) / p.body.model.count; },
     kEverywhere},
    {"build", kSeconds, "", [](const P& p) -> Json { return p.body.build_seconds; }, kInReport},
    {"step_p50", kMilliseconds, "step, median", [](const P& p) -> Json { return percentile(p.seconds, 0.5); },
     kEverywhere, "a step of {} (median)"},
    {"step_p99", kMilliseconds, "step, 99th percentile",
     [](const P& p) -> Json { return percentile(p.seconds, 0.99); }, kEverywhere},
    {"thickness", kMillimeters, "thickness",
     [](const P& p) -> Json { return p.body.model.params.collision.thickness; }},
    {"smallest_distance", kMillimeters, "smallest distance between layers",
     [](const P& p) { return std::isfinite(p.self.smallest) ? Json(p.self.smallest) : Json(); }},
    {"pairs_too_near", kCount, "pairs closer than 0.99 of the thickness",
     [](const P& p) -> Json { return p.self.too_near; }, kEverywhere},
    {"triangles_crossing", kCount, "pairs of intersecting triangles",
     [](const P& p) -> Json { return p.self.crossings; }, kEverywhere, "crossing triangles of {}"},
    {"state_hash", kNone, "state hash",
     [](const P& p) -> Json { return hash_text(cloth::state_hash(p.body.model, p.body.state)); }},
};

/// All obstacles, or holds, of all cloth bodies.
Json all_items(const Json& report, const char* key) {
  Json items = Json::array();
  for (const Json& cloth : bodies_of(report, BodyKind::kCloth))
    for (const Json& item : items_of(cloth, key)) items.push_back(item);
  return items;
}

}  // namespace

Json report_body(const ReportInput& input, const ClothScene&, const ClothBody& body, BodyId) {
  const World& world = input.world;

  // input
  ClothInput cloth{.body = body,
                   .bytes = cloth::memory_bytes(body.model, body.state),
                   .self = cloth::self_distance(input.exec, body.model, body.state),
                   .seconds = {}};
  std::vector<ClothSample> measured;
  for (const ClothSample& s : body.samples) {
    cloth.seconds.push_back(s.seconds);
    if (s.is_snapshot) measured.push_back(s);
  }

  // body, obstacles and holds
  Json json = values_of(kCloth, cloth), obstacles = Json::array(), holds = Json::array();
  for (const ClothObstacle& o : body.obstacles) {
    obstacles.push_back(
        values_of(kObstacle, ClothForce{world, body, &o, nullptr, mean_force(o.force, world.dt)}));
    add_rows(obstacles.back(), "series_columns", "series", kForce, forces_over_time(body, o.force));
  }
  for (const ClothHold& h : body.holds) {
    holds.push_back(values_of(kHold, ClothForce{world, body, nullptr, &h, mean_force(h.force, world.dt)}));
    add_rows(holds.back(), "series_columns", "series", kForce, forces_over_time(body, h.force));
  }

  // series
  json["obstacles"] = std::move(obstacles), json["holds"] = std::move(holds);
  json["force_series_columns"] = {"time_s", "force_N"};
  add_rows(json, "series_columns", "series", kSteps, body.samples);
  add_rows(json, "snapshot_columns", "snapshots", kSnapshots, measured);
  return json;
}

Section obstacle_section() {
  return {"Cloth supports (mean of the last half second)", "obstacle",
          [](const Json& report) { return all_items(report, "obstacles"); }, captions_of(kObstacle)};
}
Section hold_section() {
  return {"Cloth holds", "hold", [](const Json& report) { return all_items(report, "holds"); },
          captions_of(kHold)};
}
Section cloth_section() {
  return {"Cloth",
          "cloth",
          [](const Json& report) { return bodies_of(report, BodyKind::kCloth); },
          captions_of(kCloth),
          false,
          true};
}

namespace {

/// Weight of a rigid body or a body of finite elements that nothing fixes [N]; 0 for other bodies.
double free_weight(const World& world, BodyId id) {
  const double g = norm(world.gravity);
  const auto n = std::size_t(id.index);
  if (id.kind == BodyKind::kRigid) {
    const RigidBody& body = world.rigid_bodies[n];
    return body.model.is_fixed ? 0 : g * body.model.mass.mass;
  }
  if (id.kind != BodyKind::kSfem || !world.sfem_bodies[n].flight) return 0;
  const std::vector<double>& mass = world.sfem_bodies[n].model.mass;
  return g * std::accumulate(mass.begin(), mass.end(), 0.0);
}

/// Warning of cloth that bears a free body by sweeps; empty if none does. The force of such cloth acts on the
/// body relaxed, thus late, which gives it energy. Other cloth moves together with the body
/// (bodies/cloth/free_support.hpp).
std::string borne_body_warning(const World& world, const ClothBody& body, const ClothObstacle& obstacle) {
  constexpr int kFrames = 3;  // that a body is lifted by more than half of its weight
  if (!obstacle.support || moves_with(world, body, obstacle.support->body)) return "";
  const double weight = free_weight(world, obstacle.support->body);
  if (!(weight > 0)) return "";
  const Vec3d up = -normalized(world.gravity);
  double most = 0;
  int frames = 0;
  for (const Vec3d force : obstacle.force)
    most = std::max(most, dot(force, up)), frames += dot(force, up) > weight / 2;
  if (frames < kFrames) return "";
  return fmt::format(
      "{}: obstacle.{}: the cloth bears a body that nothing fixes (up to {:.3g} N, its weight is {:.3g} N). "
      "With sweeps, such a body may be thrown or fall through; expected solver.method = \"two_level\", a "
      "fixed "
      "body, or one that lies on something else",
      body.name, obstacle.name, most, weight);
}

}  // namespace

std::vector<std::string> cloth_warnings(const World& world) {
  std::vector<std::string> warnings;
  for (const ClothBody& body : world.cloth_bodies) {
    if (const std::string warning = residual_warning(body); !warning.empty()) warnings.push_back(warning);
    for (const ClothHold& hold : body.holds)
      if (!hold.missed.empty())
        warnings.push_back(
            fmt::format("{}: hold.{}: no vertex of the cloth was in its ball at {} s: the hold is empty; {}",
                        body.name, hold.scene.name, hold.scene.start, hold.missed));
    for (const ClothObstacle& obstacle : body.obstacles)
      if (const std::string warning = borne_body_warning(world, body, obstacle); !warning.empty())
        warnings.push_back(warning);
  }
  return warnings;
}

namespace page {

std::string cloth_curves(const Json& report) {
  const Json cloths = bodies_of(report, BodyKind::kCloth);
  if (cloths.empty()) return "";
  // empty plots
  constexpr SeriesKeys kForceSeries{"series_columns", "series"},
      kStepSeries = kForceSeries, kSnapshotSeries{"snapshot_columns", "snapshots"};
  Plot contacts{"Contacts", "time [s]", "contacts", {}},
      energy{"Elastic and kinetic energy", "time [s]", "energy [J]", {}},
      residual{"Residual of the linear system", "time [s]", "|b - W dv| / |b|", {}},
      force{"Force on the supports of cloth", "time [s]", "force [N]", {}},
      hold{"Force on the holds of cloth", "time [s]", "force [N]", {}};
  // one curve per cloth, obstacle and hold
  for (const Json& cloth : cloths) {
    const std::string name = cloth.at("name").get<std::string>();
    contacts.curves.push_back(curve_of(name, cloth, kStepSeries, "time_s", "contacts"));
    energy.curves.push_back(curve_of(name, cloth, kSnapshotSeries, "time_s", "energy_J"));
    residual.curves.push_back(curve_of(name, cloth, kSnapshotSeries, "time_s", "residual_relative"));
    for (const Json& item : items_of(cloth, "obstacles"))
      force.curves.push_back(curve_of(name + " on " + item.at("name").get<std::string>(), item, kForceSeries,
                                      "time_s", "force_N"));
    for (const Json& item : items_of(cloth, "holds"))
      hold.curves.push_back(curve_of(name + " by " + item.at("name").get<std::string>(), item, kForceSeries,
                                     "time_s", "force_N"));
  }
  // assemble the section
  return "<h2>Cloth over time</h2>\n<div class=\"grid\">" + plot_html(force) + plot_html(hold) +
         plot_html(energy) + plot_html(contacts) + plot_html(residual) + "</div>\n";
}

}  // namespace page

}  // namespace turgor
