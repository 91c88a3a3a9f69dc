#include "turgor/sim/live/stitch_results.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

std::vector<HandStitch> hand_stitches(const Scene& scene, const World& world) {
  std::vector<HandStitch> stitches;
  for (std::size_t s = scene.sutures.size(); s < world.sutures.size(); s++) {
    const SutureScene& own = world.sutures[s].scene;
    HandStitch& stitch = stitches.emplace_back(HandStitch{.suture = int(s)});
    stitch.request = {.body = own.body,
                      .wound = own.incision,
                      .through = own.through,
                      .thread = own.material,
                      .duration = own.pull.duration};
    if (!own.pull.until_closed) stitch.request.tension = own.pull.tension;
    // present state
    const std::optional<lattice::WoundClosure>& closure = world.sutures[s].closure;
    if (!closure) continue;
    TURGOR_CHECK(closure->stitches.size() == 1, "a suture by a request is a single stitch");
    const lattice::Stitch& laid = closure->stitches.front();
    const lattice::Motion& motion = world.lattice_bodies[std::size_t(own.body)].state->motion;
    stitch.phase = laid.phase, stitch.tension = laid.tension, stitch.gape = gape_under(laid, motion);
    for (const Vec3d f : stitch_forces(laid, motion)) stitch.force = std::max(stitch.force, norm(f));
  }
  return stitches;
}

}  // namespace turgor
