#include "turgor/sim/live/session_ct.hpp"

#include <algorithm>

namespace turgor {

namespace {

/// True if the body has not changed visibly since its CT was computed. A CT from before the first frame
/// counts as outdated, because the state was not yet on its device.
bool is_ct_current(const LatticeBody& body, const SessionCt& cached) {
  const Vec3d spacing = body.ct.grid.spacing;
  return cached.ct->frame > 0 && cut_version(body.state.cuts()) == cached.cuts &&
         cached.motion <= 0.01 * std::min({spacing.x, spacing.y, spacing.z});
}

}  // namespace

void update_ct(const Exec& exec, const World& world, CtTargets targets, int max_samples, SessionCt& cached) {
  if (world.lattice_bodies.empty()) return;
  const LatticeBody& body = world.lattice_bodies[0];
  if (cached.ct && cached.ct->covers(targets) && is_ct_current(body, cached)) return;
  cached = {
      std::make_shared<const DeformedCt>(make_deformed_ct(exec, body, world.frame, targets, max_samples)), 0,
      cut_version(body.state.cuts())};
}

void add_motion(const World& world, SessionCt& cached) {
  if (world.lattice_bodies.empty()) return;
  cached.motion += world.lattice_bodies[0].last_displacement;
}

}  // namespace turgor
