#include "turgor/models/cloth/crossing.hpp"

#include <algorithm>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/cloth.hpp"

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
void join_zones(Crossing& crossing) {
  auto &caught = crossing.caught, &zone = crossing.zone;
  caught.clear();
  for (const Meeting& m : crossing.meetings) caught.insert(caught.end(), m.vertex.begin(), m.vertex.end());
  sort_unique(caught);
  zone.resize(caught.size());
  for (std::size_t n = 0; n < zone.size(); n++) zone[n] = int(n);
  const auto index = [&](int v) {
    return int(std::lower_bound(caught.begin(), caught.end(), v) - caught.begin());
  };
  for (const Meeting& m : crossing.meetings)
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
  const Crossing& crossing = state.crossing;
  std::vector<ZoneMotion> motions(crossing.caught.size());
  for (std::size_t n = 0; n < crossing.caught.size(); n++) {
    const auto v = std::size_t(crossing.caught[n]);
    ZoneMotion& zone = motions[std::size_t(crossing.zone[n])];
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

int avoid_crossings(const Exec& exec, const Model& model, State& state) {
  constexpr int kPatience = 30;
  Crossing& crossing = state.crossing;
  if (crossing.steps_to_look == 0)
    crossing.steps_to_look = crosses_itself(exec, model, state.system.before) ? kPatience : -1;
  if (crossing.steps_to_look > 0) {
    crossing.steps_to_look--;
    return 0;
  }
  System& system = state.system;
  crossing.meetings.clear(), crossing.caught.clear(), crossing.zone.clear();
  set_motion(exec, state);
  std::vector<ZoneMotion> motions;
  for (bool all = true;; all = false) {
    measure_triangles(exec, model, state);
    place_boxes(exec, model, state);
    if (!find_meetings(exec, model, state, all)) break;
    join_zones(crossing);
    motions = zone_motions(model, state);
    for (std::size_t n = 0; n < crossing.caught.size(); n++)
      system.force.set(std::size_t(crossing.caught[n]), Vec3(motions[std::size_t(crossing.zone[n])].way));
  }
  for (std::size_t n = 0; n < crossing.caught.size(); n++) {
    const auto v = std::size_t(crossing.caught[n]);
    state.x.set(v, system.before[v] + system.force[v]);
    if (state.free_mass[v] > 0) state.v.set(v, Vec3(motions[std::size_t(crossing.zone[n])].v));
  }
  return int(crossing.caught.size());
}

}  // namespace turgor::cloth
