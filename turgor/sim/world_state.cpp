#include "turgor/sim/world_state.hpp"

#include <span>
#include <type_traits>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"

namespace turgor {

namespace {

/// Immutable data of bodies, moved out while the rest is copied, then moved back. No other thread reads it,
/// since patches under construction are waited for.
struct Immutable {
  World world;
};

template <class Body>
void wait_for_patch(const Body&) {}
void wait_for_patch(const SfemBody& body) {
  if (body.worker) body.worker->settle();
}

template <class Body>
void move_immutable(Body& from, Body& to) {
  if constexpr (requires { from.model; }) to.model = std::move(from.model);
  if constexpr (std::is_same_v<Body, LatticeBody>) to.ct = std::move(from.ct);
}

/// Between two worlds with the same number of bodies.
void move_all(World& from, World& to) {
  for_each_kind(from, to, [](BodyKind, auto& bodies, auto& others) {
    TURGOR_CHECK(bodies.size() == others.size(), "a state has the bodies of its world");
    for (std::size_t b = 0; b < bodies.size(); b++) move_immutable(bodies[b], others[b]);
  });
}

Immutable take_out(World& world) {
  Immutable out;
  for_each_kind(world, out.world, [](BodyKind, auto& bodies, auto& others) { others.resize(bodies.size()); });
  for_each_body(world, [](BodyId, const auto& body) { wait_for_patch(body); });
  move_all(world, out.world);
  return out;
}

/// Moves immutable data out, and back in its destructor.
struct WithoutImmutable {
  World& world;
  Immutable immutable;
  explicit WithoutImmutable(World& w) : world(w), immutable(take_out(w)) {}
  ~WithoutImmutable() { move_all(immutable.world, world); }
  WithoutImmutable(const WithoutImmutable&) = delete;
  WithoutImmutable& operator=(const WithoutImmutable&) = delete;
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
  const WithoutImmutable out(world);
  return {world};
}

void set_state(World& world, const WorldState& state) {
  TURGOR_ASSERT(has_same_bodies(world, state.world), "a state is of a world with the same bodies and tools");
  const WithoutImmutable out(world);
  world = state.world;
}

void take_state(World& world, World& from) {
  TURGOR_ASSERT(has_same_bodies(world, from), "a state is of a world with the same bodies and tools");
  {
    const WithoutImmutable out(world), other(from);
    world = from;  // copies the values into the present memory
  }
  for (std::size_t b = 0; b < world.sfem_bodies.size(); b++)
    if (world.sfem_bodies[b].facts.on_demand)
      world.sfem_bodies[b].model.green = std::move(from.sfem_bodies[b].model.green);
}

std::uint64_t cuts_hash(const World& world) {
  std::uint64_t hash = kHashSeed;
  for (const LatticeBody& body : world.lattice_bodies) {
    const lattice::Cuts& cuts = body.state.cuts();
    hash = hash_long_bytes(cuts.removed.data(), cuts.removed.size(), hash);
    hash = hash_values(std::span<const std::uint64_t>(cuts.excised), hash);
    for (const lattice::CutEdge& edge : cuts.edges) {
      const std::int32_t position[] = {edge.slot, edge.sub_index, edge.family};
      hash = hash_bytes(&edge.fraction, sizeof edge.fraction, hash_bytes(position, sizeof position, hash));
    }
  }
  return hash;
}

World copy_of(const World& world) { return world; }

}  // namespace turgor
