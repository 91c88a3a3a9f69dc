#include "turgor/sim/world_state.hpp"

#include <type_traits>

namespace turgor {

namespace {

/// What of a body never changes: taken out while the rest is copied, and put back. Nobody reads it meanwhile,
/// since a patch that is being built is waited for.
struct Unchanging {
  World world;
};

template <class Body>
void settle(const Body&) {}
void settle(const SfemBody& body) {
  if (body.worker) body.worker->settle();
}

template <class Body>
void move_unchanging(Body& from, Body& to) {
  if constexpr (requires { from.model; }) to.model = std::move(from.model);
  if constexpr (std::is_same_v<Body, LatticeBody>) to.ct = std::move(from.ct);
}

/// From the bodies of one world to those of another that has as many.
void move_all(World& from, World& to) {
  for_each_kind(from, to, [](BodyKind, auto& bodies, auto& others) {
    for (std::size_t b = 0; b < bodies.size(); b++) move_unchanging(bodies[b], others[b]);
  });
}

Unchanging take_out(World& world) {
  Unchanging out;
  for_each_kind(world, out.world, [](BodyKind, auto& bodies, auto& others) { others.resize(bodies.size()); });
  for_each_body(world, [](BodyId, const auto& body) { settle(body); });
  move_all(world, out.world);
  return out;
}

/// Puts it back, whatever happens meanwhile.
struct TakenOut {
  World& world;
  Unchanging kept;
  explicit TakenOut(World& w) : world(w), kept(take_out(w)) {}
  ~TakenOut() { move_all(kept.world, world); }
  TakenOut(const TakenOut&) = delete;
  TakenOut& operator=(const TakenOut&) = delete;
};

bool has_same_bodies(const World& a, const World& b) {
  bool same = a.tools.size() == b.tools.size();
  for_each_kind(a, b, [&same](BodyKind, const auto& of_a, const auto& of_b) {
    same = same && of_a.size() == of_b.size();
  });
  return same;
}

}  // namespace

WorldState state_of(World& world) {
  const TakenOut out(world);
  return {world};
}

void set_state(World& world, const WorldState& state) {
  TURGOR_ASSERT(has_same_bodies(world, state.world), "a state is of a world with the same bodies and tools");
  const TakenOut out(world);
  world = state.world;
}

World copy_of(const World& world) { return world; }

}  // namespace turgor
