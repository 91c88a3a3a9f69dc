#include "turgor/sim/replace_cuts.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor {

Status replace_cuts(const Scene& scene, World& world) {
  TURGOR_ASSERT(world.frame == 0, "cuts are replaced before the first frame");
  world.cuts.clear(), world.sutures.clear();
  for (const IncisionScene& incision : scene.incisions) {
    TURGOR_CHECK(is_index(incision.body, world.lattice_bodies.size()), "an incision cuts a lattice");
    Result<Cut> cut = load_cut(incision, world.lattice_bodies[std::size_t(incision.body)], world.cuts);
    if (!cut) return cut.error();
    world.cuts.push_back(std::move(*cut));
  }
  for (const SutureScene& stitches : scene.sutures) {
    Result<Suture> suture = load_suture(stitches, world.lattice_bodies[std::size_t(stitches.body)],
                                        world.cuts[std::size_t(stitches.incision)]);
    if (!suture) return suture.error();
    world.sutures.push_back(std::move(*suture));
  }
  return Done{};
}

}  // namespace turgor
