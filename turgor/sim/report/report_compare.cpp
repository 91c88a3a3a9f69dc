#include "turgor/sim/report/report_compare.hpp"

#include <algorithm>

#include "turgor/core/timing.hpp"
#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {

namespace {

/// Means over rings of a millimetre around the vertex that moved most.
Json profile(const ShownBody& surface) {
  constexpr std::size_t kRings = 80;
  constexpr double kRing = 1e-3;  // [m]
  std::size_t most = 0;
  for (std::size_t v = 1; v < surface.rest.size(); v++)
    if (norm(surface.displacement[v]) > norm(surface.displacement[most])) most = v;
  std::vector<double> sum(kRings), count(kRings);
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const auto ring = std::size_t(double(norm(surface.rest[v] - surface.rest[most])) / kRing);
    if (ring < kRings) sum[ring] += norm(surface.displacement[v]), count[ring]++;
  }
  Json rows = Json::array();
  for (std::size_t r = 0; r < kRings; r++)
    if (count[r] > 0) rows.push_back(numbers({(double(r) + 0.5) * kRing * kMm, sum[r] / count[r] * kMm}));
  return rows;
}

double build_seconds(const SfemBody& body) { return body.facts.shape_seconds + body.facts.green_seconds; }
double build_seconds(const RhombusBody& body) { return body.build_seconds; }
double build_seconds(const LatticeBody& body) { return body.read_seconds + body.build_seconds; }

template <class Body>
Json cost_row(const World& world, const Pressed& pressed, const Body& body) {
  const BodyId id = pressed.id;
  std::vector<double> seconds;
  double depth = 0;
  for (const int t : body.tool_indices)
    for (const ForceSample& s : world.tools[std::size_t(t)].samples) {
      if (t == body.tool_indices[0]) seconds.push_back(s.tick_seconds);  // of all tools together
      depth = std::max(depth, s.depth);
    }
  double dent = 0;
  for (const Vec3 u : pressed.body.displacement) dent = std::max(dent, double(norm(u)));
  return {{"name", body.name},
          {"model", model_name(id.kind)},
          {"build_s", rounded(build_seconds(body))},
          {"force_every_ms", rounded(force_interval(world, id) * kMs)},
          {"force_p50_ms", rounded(percentile(seconds, 0.5) * kMs)},
          {"force_p99_ms", rounded(percentile(seconds, 0.99) * kMs)},
          {"surface_p50_ms", rounded(percentile(pressed.surface_seconds, 0.5) * kMs)},
          {"force_max_N", rounded(pressed.force)},
          {"force_max_at_s", rounded(pressed.time)},
          {"depth_max_mm", rounded(depth * kMm)},
          {"displacement_max_mm", rounded(dent * kMm)}};
}

}  // namespace

double force_interval(const World& world, BodyId id) {
  return id.kind == BodyKind::kLattice ? world.dt : kTick;
}

Json profile_report(const Measures& measures) {
  Json profiles = Json::array();
  for (const Pressed& pressed : measures.pressed) {
    if (!(pressed.force > 0) || pressed.body.rest.empty()) continue;
    profiles.push_back({{"name", pressed.body.name},
                        {"columns", {"distance_mm", "displacement_mm"}},
                        {"rows", profile(pressed.body)}});
  }
  return profiles;
}

Json cost_report(const World& world, const Measures& measures) {
  Json rows = Json::array();
  for_each_touched(world, [&](BodyId id, const auto& body) {
    if (!body.tool_indices.empty()) rows.push_back(cost_row(world, pressed_body(measures.pressed, id), body));
  });
  return rows;
}

}  // namespace turgor
