#include "turgor/models/cloth/ccd/ccd.hpp"

#include <algorithm>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 64;  // batches

/// Displacements from where the cloth was to where it wants to be.
void set_motion(const Exec& exec, State& state) {
  parallel_for(
      exec, state.x.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        store(state.system.force, i, load(state.x, i) - load(state.system.before, i));
      },
      kGrain);
}

bool crosses_itself(const Exec& exec, const Model& model, const Vectors& x) {
  TriMesh mesh{.triangles = model.triangles};
  for (int v = 0; v < model.count; v++) mesh.vertices.push_back(x[std::size_t(v)]);
  return !crossing_triangles(exec, mesh).empty();
}

/// What meets, directly or through others, becomes one zone, named by its smallest member.
void join_zones(CcdWorkspace& ccd) {
  auto &in_impact_zone = ccd.in_impact_zone, &zone = ccd.zone;
  in_impact_zone.clear();
  for (const CcdPair& m : ccd.ccd_pairs)
    in_impact_zone.insert(in_impact_zone.end(), m.vertex.begin(), m.vertex.end());
  sort_unique(in_impact_zone);
  zone.resize(in_impact_zone.size());
  for (std::size_t n = 0; n < zone.size(); n++) zone[n] = int(n);
  const auto index = [&](int v) {
    return int(std::lower_bound(in_impact_zone.begin(), in_impact_zone.end(), v) - in_impact_zone.begin());
  };
  for (const CcdPair& m : ccd.ccd_pairs)
    for (std::size_t k = 1; k < 4; k++) join_sets(zone, index(m.vertex[0]), index(m.vertex[k]));
  for (std::size_t n = 0; n < zone.size(); n++) zone[n] = root_of(zone, int(n));
}

struct ZoneMotion {
  double mass = 0;  // [kg]
  Vec3d way, v;     // displacement and velocity [m] [m/s]
  bool is_held = false;
};

/// The mean motion of each zone: momentum is kept. Where vertices are held, only these count.
std::vector<ZoneMotion> zone_motions(const Model& model, const State& state) {
  const CcdWorkspace& ccd = state.ccd;
  std::vector<ZoneMotion> motions(ccd.in_impact_zone.size());
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++) {
    const auto v = std::size_t(ccd.in_impact_zone[n]);
    ZoneMotion& zone = motions[std::size_t(ccd.zone[n])];
    const bool is_held = state.free_mass[v] == 0;
    if (zone.is_held && !is_held) continue;
    if (is_held && !zone.is_held) zone = {.is_held = true};
    const double mass = double(model.mass[v]);
    zone.mass += mass;
    zone.way += (Vec3d(state.x[v]) - Vec3d(state.system.before[v])) * mass;
    zone.v += Vec3d(state.v[v]) * mass;
  }
  for (ZoneMotion& zone : motions)
    if (zone.mass > 0) zone.way *= 1 / zone.mass, zone.v *= 1 / zone.mass;
  return motions;
}

}  // namespace

int resolve_ccd(const Exec& exec, const Model& model, State& state) {
  constexpr int kPatience = 30;
  CcdWorkspace& ccd = state.ccd;
  if (ccd.steps_to_look == 0)
    ccd.steps_to_look = crosses_itself(exec, model, state.system.before) ? kPatience : -1;
  if (ccd.steps_to_look > 0) {
    ccd.steps_to_look--;
    return 0;
  }
  System& system = state.system;
  ccd.ccd_pairs.clear(), ccd.in_impact_zone.clear(), ccd.zone.clear();
  set_motion(exec, state);
  std::vector<ZoneMotion> motions;
  for (bool all = true;; all = false) {
    measure_triangles(exec, model, state);
    place_boxes(exec, model, state);
    if (!find_ccd_pairs(exec, model, state, all)) break;
    join_zones(ccd);
    motions = zone_motions(model, state);
    for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++)
      system.force.set(std::size_t(ccd.in_impact_zone[n]), Vec3(motions[std::size_t(ccd.zone[n])].way));
  }
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++) {
    const auto v = std::size_t(ccd.in_impact_zone[n]);
    state.x.set(v, system.before[v] + system.force[v]);
    if (state.free_mass[v] > 0) state.v.set(v, Vec3(motions[std::size_t(ccd.zone[n])].v));
  }
  return int(ccd.in_impact_zone.size());
}

}  // namespace turgor::cloth
