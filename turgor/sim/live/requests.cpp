#include "turgor/sim/live/requests.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/undo_cut.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status apply_request(const Exec&, const CutRequest& request, std::shared_ptr<const Scene>&, World& world) {
  if (request.body < 0 || std::size_t(request.body) >= world.lattice_bodies.size())
    return Error{"no cut: unknown lattice body"};
  Cut cut{.blade = request.blade, .body = request.body, .path = {}, .done = 0, .edges = 0};
  cut.blade.start = time_of(world);
  const LatticeBody& body = world.lattice_bodies[std::size_t(request.body)];
  const Result<lattice::BladePath> trial = lattice::lay_blade(body.model, body.state, cut.blade);
  constexpr std::size_t kMostCuts = 255;  // a cut edge stores its incision in a byte
  if (!trial) return Error{"no cut: " + trial.error().message};
  if (world.cuts.size() == kMostCuts) return Error{"no cut: a world holds at most 255"};
  cut.before = state_before_cut(world, body);
  world.cuts.push_back(std::move(cut));
  return Done{};
}

Status apply_request(const Exec&, const WindRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world) {
  if (request.body < 0 || std::size_t(request.body) >= world.cloth_bodies.size())
    return Error{"no wind: unknown cloth body"};
  ClothBody& body = world.cloth_bodies[std::size_t(request.body)];
  if (request.velocity) {
    body.turns.clear(), body.air.velocity = *request.velocity;
    return Done{};
  }
  TURGOR_ASSERT(scene != nullptr, "a scene has the wind that a request returns to");
  TURGOR_CHECK(scene->cloth_bodies.size() == world.cloth_bodies.size(),
               "a scene has the bodies of its world");
  const ClothScene& own = scene->cloth_bodies[std::size_t(request.body)];
  body.air = own.air, body.turns = own.turns;
  return Done{};
}

Status apply_request(const Exec& exec, const ChangeRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world) {
  TURGOR_ASSERT(scene != nullptr, "a change applies to a scene");
  Result<Scene> changed = with_change(*scene, request.key, request.value);
  if (!changed) return changed.error();
  change_world(exec, *scene, *changed, world);
  scene = std::make_shared<const Scene>(std::move(*changed));
  return Done{};
}

Status apply_request(const Exec&, const UndoCutRequest&, std::shared_ptr<const Scene>& scene, World& world) {
  TURGOR_ASSERT(scene != nullptr, "cuts by requests follow those of a scene");
  if (world.cuts.size() <= scene->incisions.size()) return Error{"no undo: there is no cut by hand"};
  const int latest = int(world.cuts.size()) - 1;
  for (const Suture& suture : world.sutures)
    if (suture.scene.incision == latest) return Error{"no undo: a stitch by hand closes the cut"};
  return undo_last_cut(world);
}

}  // namespace turgor
