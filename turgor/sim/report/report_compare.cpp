#include "turgor/sim/report/report_compare.hpp"

#include <algorithm>

#include "turgor/core/timing.hpp"
#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {

namespace {

/// Means over rings of a millimetre around the vertex that moved most.
Json profile(const OrganSurface& surface) {
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

double build_seconds(const World& world, std::size_t index) {
  if (index < world.organs.size())
    return world.organs[index].facts.shape_seconds + world.organs[index].facts.green_seconds;
  if (index < organ_count(world)) return world.rhombi[index - world.organs.size()].build_seconds;
  const LatticeBody& body = world.lattices[index - organ_count(world)];
  return body.read_seconds + body.build_seconds;
}

const char* model_name(const World& world, std::size_t index) {
  return index < world.organs.size() ? "sfem" : index < organ_count(world) ? "rhombus" : "lattice";
}

Json cost_row(const World& world, std::size_t index) {
  const TouchedOrgan& organ = touched_organ(world, index);
  std::vector<double> seconds;
  double depth = 0;
  for (const int t : organ.tool_indices)
    for (const ForceSample& s : world.tools[std::size_t(t)].samples) {
      if (t == organ.tool_indices[0]) seconds.push_back(s.tick_seconds);  // of all tools together
      depth = std::max(depth, s.depth);
    }
  double dent = 0;
  for (const Vec3 u : organ.deepest.displacement) dent = std::max(dent, double(norm(u)));
  return {{"name", organ.name},
          {"model", model_name(world, index)},
          {"build_s", rounded(build_seconds(world, index))},
          {"force_every_ms", rounded(force_interval(world, index) * kMs)},
          {"force_p50_ms", rounded(percentile(seconds, 0.5) * kMs)},
          {"force_p99_ms", rounded(percentile(seconds, 0.99) * kMs)},
          {"surface_p50_ms", rounded(percentile(organ.surface_seconds, 0.5) * kMs)},
          {"force_max_N", rounded(organ.largest_force)},
          {"force_max_at_s", rounded(organ.deepest.time)},
          {"depth_max_mm", rounded(depth * kMm)},
          {"displacement_max_mm", rounded(dent * kMm)}};
}

}  // namespace

double force_interval(const World& world, std::size_t index) {
  return index < organ_count(world) ? kTick : world.dt;
}

Json profile_report(const World& world) {
  Json profiles = Json::array();
  for (std::size_t o = 0; o < touched_count(world); o++) {
    const TouchedOrgan& organ = touched_organ(world, o);
    if (!(organ.largest_force > 0) || organ.deepest.rest.empty()) continue;
    profiles.push_back({{"name", organ.name},
                        {"columns", {"distance_mm", "displacement_mm"}},
                        {"rows", profile(organ.deepest)}});
  }
  return profiles;
}

Json cost_report(const World& world) {
  Json rows = Json::array();
  for (std::size_t o = 0; o < touched_count(world); o++)
    if (!touched_organ(world, o).tool_indices.empty()) rows.push_back(cost_row(world, o));
  return rows;
}

}  // namespace turgor
