#include "turgor/sim/live/asks.hpp"

#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status grant(const Exec&, const AskCut& ask, std::shared_ptr<const Scene>&, World& world) {
  if (ask.body < 0 || std::size_t(ask.body) >= world.lattice_bodies.size())
    return Error{"no cut: there is no such lattice"};
  Cut cut{.blade = ask.blade, .body = ask.body, .path = {}, .done = 0, .edges = 0};
  cut.blade.start = time_of(world);
  const LatticeBody& body = world.lattice_bodies[std::size_t(ask.body)];
  const Result<lattice::BladePath> trial = lattice::lay_blade(body.model, body.state, cut.blade);
  constexpr std::size_t kMostCuts = 255;  // a cut edge remembers its incision in a byte
  if (!trial) return Error{"no cut: " + trial.error().message};
  if (world.cuts.size() == kMostCuts) return Error{"no cut: a world holds at most 255"};
  world.cuts.push_back(std::move(cut));
  return Done{};
}

Status grant(const Exec&, const AskWind& ask, std::shared_ptr<const Scene>&, World& world) {
  if (ask.body < 0 || std::size_t(ask.body) >= world.cloth_bodies.size())
    return Error{"no wind: there is no such cloth"};
  ClothBody& body = world.cloth_bodies[std::size_t(ask.body)];
  body.turns.clear(), body.air.velocity = ask.velocity;
  return Done{};
}

Status grant(const Exec& exec, const AskChange& ask, std::shared_ptr<const Scene>& scene, World& world) {
  Result<Scene> changed = with_change(*scene, ask.key, ask.value);
  if (!changed) return changed.error();
  change_world(exec, *scene, *changed, world);
  scene = std::make_shared<const Scene>(std::move(*changed));
  return Done{};
}

}  // namespace turgor
