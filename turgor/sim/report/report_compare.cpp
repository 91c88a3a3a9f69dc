#include "turgor/sim/report/report_compare.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;

/// Ring around the most displaced vertex.
struct Ring {
  double distance = 0, displacement = 0;  // means over its vertices [m]
};
const Quantity<Ring> kRing[] = {
    {"distance", kMillimeters, "distance from the deepest point",
     [](const Ring& r) -> Json { return r.distance; }},
    {"displacement", kMillimeters, "displacement", [](const Ring& r) -> Json { return r.displacement; }},
};

/// Means over rings one millimeter wide.
std::vector<Ring> rings_of(const BodySnapshot& surface) {
  constexpr std::size_t kRings = 80;
  constexpr double kRingWidth = 1e-3;  // [m]
  std::size_t most = 0;
  TURGOR_CHECK(surface.displacement.size() == surface.rest.size(), "every vertex has a displacement");
  for (std::size_t v = 1; v < surface.rest.size(); v++)
    if (norm(surface.displacement[v]) > norm(surface.displacement[most])) most = v;
  std::vector<double> sum(kRings), count(kRings);
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const auto ring = std::size_t(double(norm(surface.rest[v] - surface.rest[most])) / kRingWidth);
    if (ring < kRings) sum[ring] += norm(surface.displacement[v]), count[ring]++;
  }
  std::vector<Ring> rings;
  for (std::size_t r = 0; r < kRings; r++)
    if (count[r] > 0) rings.push_back({(double(r) + 0.5) * kRingWidth, sum[r] / count[r]});
  return rings;
}

double build_seconds(const SfemBody& body) { return body.facts.shape_seconds + body.facts.green_seconds; }
double build_seconds(const RhombusBody& body) { return body.build_seconds; }
double build_seconds(const LatticeBody& body) { return body.read_seconds + body.build_seconds; }
double build_seconds(const ClothBody& body) { return body.build_seconds; }
double build_seconds(const RigidBody&) { return 0; }

struct Cost {
  const TouchedBody& body;
  const Pressed& pressed;
  double build, interval;            // [s]
  std::vector<double> tick_seconds;  // all tools together
  double depth = 0, dent = 0;        // [m]
};

const Quantity<Cost> kCost[] = {
    {"name", kNone, "", [](const Cost& c) -> Json { return c.body.name; }, kInReport},
    {"model", kNone, "model", [](const Cost& c) -> Json { return model_name(c.pressed.id.kind); }},
    {"force_max", kNewtons, "largest force", [](const Cost& c) -> Json { return c.pressed.force; }},
    {"force_max_at", kSeconds, "… at", [](const Cost& c) -> Json { return c.pressed.time; }},
    {"depth_max", kMillimeters, "largest depth", [](const Cost& c) -> Json { return c.depth; }},
    {"displacement_max", kMillimeters, "largest displacement", [](const Cost& c) -> Json { return c.dent; }},
    {"build", kSeconds, "reading and building", [](const Cost& c) -> Json { return c.build; }},
    {"force_every", kMilliseconds, "interval of forces", [](const Cost& c) -> Json { return c.interval; }},
    {"force_p50", kMilliseconds, "… takes, median",
     [](const Cost& c) -> Json { return wall_time(c.tick_seconds, 0.5); }},
    {"force_p99", kMilliseconds, "… 99th percentile",
     [](const Cost& c) -> Json { return wall_time(c.tick_seconds, 0.99); }},
    {"surface_p50", kMilliseconds, "surface for a picture, median",
     [](const Cost& c) -> Json { return percentile(c.pressed.surface_seconds, 0.5); }},
};

template <class Body>
Cost cost_of(const World& world, const Pressed& pressed, const Body& body) {
  Cost cost{.body = body,
            .pressed = pressed,
            .build = build_seconds(body),
            .interval = force_interval(world, pressed.id),
            .tick_seconds = {}};
  for (const int t : body.tool_indices)
    for (const ForceSample& s : world.tools[std::size_t(t)].samples) {
      if (t == body.tool_indices[0] && s.tick_seconds > 0) cost.tick_seconds.push_back(s.tick_seconds);
      cost.depth = std::max(cost.depth, s.depth);
    }
  for (const Vec3 u : pressed.body.displacement) cost.dent = std::max(cost.dent, double(norm(u)));
  return cost;
}

}  // namespace

double force_interval(const World& world, BodyId id) {
  return id.kind == BodyKind::kSfem || id.kind == BodyKind::kRhombus ? kTick : world.dt;
}

Json wall_time(const std::vector<double>& seconds, double fraction) {
  return seconds.empty() ? Json() : Json(percentile(seconds, fraction));
}

Json profile_report(const Measures& measures) {
  Json profiles = Json::array();
  for (const Pressed& pressed : measures.pressed) {
    if (!(pressed.force > 0) || pressed.body.rest.empty()) continue;
    Json profile{{"name", pressed.body.name}};
    add_rows(profile, "columns", "rows", kRing, rings_of(pressed.body));
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

Json cost_report(const World& world, const Measures& measures) {
  Json rows = Json::array();
  for_each_touched(world, [&](BodyId id, const auto& body) {
    if (!body.tool_indices.empty()) {
      const Pressed& pressed = pressed_body(measures.pressed, id);
      rows.push_back(values_of(kCost, cost_of(world, pressed, body)));
    }
  });
  return rows;
}

Section cost_section() {
  return {"Comparison of bodies", "body",
          [](const Json& report) {
            const Json costs = items_of(report, "costs");
            return costs.size() > 1 ? costs : Json::array();
          },
          captions_of(kCost)};
}

}  // namespace turgor
