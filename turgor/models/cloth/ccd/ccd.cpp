#include "turgor/models/cloth/ccd/ccd.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/ccd/ccd_zones.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kGrain = 64;  // batches

/// Displacements from the beginning of the step to the uncorrected end.
void set_displacements(const Exec& exec, const State& state, const CcdMotion& motion) {
  parallel_for(
      exec, state.x.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        store<Lanes>(motion.displacement, i, load(state.x, i) - load<Lanes>(motion.start, i));
      },
      kGrain);
}

bool intersects_itself(const Exec& exec, const Model& model, ConstVectorsView x) {
  TriMesh mesh;
  for (std::size_t t = 0; t < model.triangles.size(); t++)
    if (!model.membrane.is_sliver(t)) mesh.triangles.push_back(model.triangles[t]);
  for (int v = 0; v < model.count; v++) mesh.vertices.push_back(x[std::size_t(v)]);
  return !crossing_triangles(exec, mesh).empty();
}

struct ZoneMotion {
  double mass = 0;        // [kg]
  Vec3d displacement, v;  // displacement and velocity [m] [m/s]
  bool is_held = false;
};

/// Mean displacement and velocity of each zone, which keeps momentum. If a zone has held vertices, only these
/// count.
std::vector<ZoneMotion> zone_motions(const Model& model, const State& state, const CcdMotion& motion) {
  const CcdWorkspace& ccd = state.ccd;
  TURGOR_CHECK(ccd.zone.size() == ccd.in_impact_zone.size(), "every vertex of an impact zone has a zone");
  std::vector<ZoneMotion> motions(ccd.in_impact_zone.size());
  // sums over the vertices of each zone
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++) {
    const auto v = std::size_t(ccd.in_impact_zone[n]);
    ZoneMotion& zone = motions[std::size_t(ccd.zone[n])];
    const bool is_held = state.free_mass[v] == 0;
    if (zone.is_held && !is_held) continue;
    if (is_held && !zone.is_held) zone = {.is_held = true};
    const double mass = double(model.mass[v]);
    zone.mass += mass;
    zone.displacement += (Vec3d(state.x[v]) - Vec3d(motion.start[v])) * mass;
    zone.v += Vec3d(state.v[v]) * mass;
  }
  // means
  for (ZoneMotion& zone : motions)
    if (zone.mass > 0) zone.displacement *= 1 / zone.mass, zone.v *= 1 / zone.mass;
  return motions;
}

/// Moves each zone by its mean displacement. Returns the vertices whose displacement this changes.
std::vector<int> move_zones(const CcdWorkspace& ccd, const std::vector<ZoneMotion>& motions,
                            const CcdMotion& motion) {
  std::vector<int> changed;
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++) {
    const int v = ccd.in_impact_zone[n];
    const Vec3 displacement(motions[std::size_t(ccd.zone[n])].displacement);
    if (motion.displacement[std::size_t(v)] == displacement) continue;
    motion.displacement.set(std::size_t(v), displacement);
    changed.push_back(v);
  }
  return changed;
}

/// True if the cloth had no intersections at the beginning of the step. Else it is left alone, and tested
/// again later.
bool is_free(const Exec& exec, const Model& model, CcdWorkspace& ccd, const CcdMotion& motion) {
  constexpr int kStepsBetweenChecks = 30;
  if (ccd.steps_until_check == 0)
    ccd.steps_until_check = intersects_itself(exec, model, motion.start) ? kStepsBetweenChecks : -1;
  if (ccd.steps_until_check < 0) return true;
  ccd.steps_until_check--;
  return false;
}

}  // namespace

bool find_collisions(const Exec& exec, const Model& model, State& state) {
  CcdWorkspace& ccd = state.ccd;
  const CcdMotion motion = ccd_motion(view(model, state));
  ccd.ccd_pairs.clear(), ccd.in_impact_zone.clear(), ccd.zone.clear();
  if (!is_free(exec, model, ccd, motion)) return false;
  set_displacements(exec, state, motion);
  measure_triangles(exec, model, state);
  build_boxes(exec, model, state);
  return find_ccd_pairs(exec, model, state, false, true);
}

int resolve_ccd(const Exec& exec, const Model& model, State& state) {
  CcdWorkspace& ccd = state.ccd;
  TURGOR_CHECK(state.x.size() == model.mass.size(), "positions are on the host");
  const CcdMotion motion = ccd_motion(view(model, state));
  if (!is_free(exec, model, ccd, motion)) return 0;
  // uncorrected motion
  ccd.ccd_pairs.clear(), ccd.in_impact_zone.clear(), ccd.zone.clear();
  set_displacements(exec, state, motion);
  std::vector<ZoneMotion> motions;
  std::vector<int> changed, joined;
  // impact zones grow until no new pair collides
  for (bool all = true;; all = false) {
    const std::size_t before = ccd.ccd_pairs.size();
    if (!all) mark_changed(exec, model, changed, ccd);
    measure_triangles(exec, model, state, !all);
    build_boxes(exec, model, state, !all);
    if (!find_ccd_pairs(exec, model, state, !all)) break;
    joined.resize(std::size_t(model.count), -1);
    join_zones(ccd, before, joined);
    motions = zone_motions(model, state, motion);
    changed = move_zones(ccd, motions, motion);
  }
  TURGOR_CHECK(motions.size() == ccd.in_impact_zone.size(), "every vertex of an impact zone has a motion");
  // corrected positions and velocities
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++) {
    const auto v = std::size_t(ccd.in_impact_zone[n]);
    state.x.set(v, motion.start[v] + motion.displacement[v]);
    if (state.free_mass[v] > 0) state.v.set(v, Vec3(motions[std::size_t(ccd.zone[n])].v));
  }
  return int(ccd.in_impact_zone.size());
}

}  // namespace turgor::cloth
