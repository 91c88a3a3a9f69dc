#include "turgor/sim/report_rhombus.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/sim/json_numbers.hpp"

namespace turgor {

namespace {

struct SourceText {
  std::string operator()(const SurfaceFile& s) const { return s.file.string(); }
  std::string operator()(const PhantomLiverSurface&) const { return "phantom liver"; }
  std::string operator()(const SurfaceOfBody&) const { return "the surface of another body"; }
};

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

}  // namespace

Json rhombus_report(const RhombusScene& scene, const RhombusOrgan& organ) {
  const rhombus::ChainParams& chain = scene.params.chain;
  const rhombus::Tissue* tissue = rhombus::find_tissue(scene.tissue);
  return {{"name", organ.name},
          {"model", "rhombus"},
          {"source", std::visit(SourceText{}, scene.source)},
          {"tissue", scene.tissue},
          {"tissue_source", tissue ? tissue->source : ""},
          {"vertices", organ.model.surface.vertices.size()},
          {"triangles", organ.model.surface.triangles.size()},
          {"volume_ml", rounded(organ.volume * 1e6)},
          {"normal_N_per_m", rounded(chain.normal)},
          {"tangential_N_per_m", rounded(chain.tangential)},
          {"decay", rounded(chain.decay)},
          {"angle_deg", rounded(chain.angle * 180 / std::numbers::pi)},
          {"side_mm", rounded(chain.side * kMm)},
          {"bulge", rounded(scene.params.bulge)},
          {"build_s", rounded(organ.build_seconds)},
          {"surface_p50_ms", rounded(percentile(organ.surface_seconds, 0.5) * kMs)},
          {"pressed_volume_ml", rounded(organ.pressed_volume * 1e6)},
          {"force_max_N", rounded(organ.largest_force)},
          {"force_max_at_s", rounded(organ.deepest.time)},
          {"jump_per_10_um_N", rounded(organ.jump)},
          {"jump_at_s", rounded(organ.jump_at)}};
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

std::uint64_t rhombus_hash(const World& world) {
  std::uint64_t hash = kHashSeed;
  for (const RhombusOrgan& organ : world.rhombi) {
    const std::uint64_t one = rhombus::state_hash(organ.state);
    hash = hash_bytes(&one, sizeof one, hash);
  }
  return hash;
}

}  // namespace turgor
