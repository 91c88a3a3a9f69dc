// Identifier of a body: its model, and its index among the bodies of that model, in a scene and in its world.
// This is the only list of models. Operations on all bodies are overloads per model; a missing overload does
// not compile (docs/adding-a-model.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/result.hpp"

namespace turgor {

/// In the order in which a frame steps them: cloth after the bodies on which it lies.
enum class BodyKind : std::uint8_t { kSfem, kRhombus, kLattice, kCloth, kRigid };

/// Values of the key `model`.
constexpr const char* kModelNames[] = {"sfem", "rhombus", "lattice", "cloth", "rigid"};
constexpr std::size_t kModelCount = std::size(kModelNames);

/// Vectors of bodies in the order of BodyKind, of a scene or of a world.
template <class AnyWorld>
auto bodies_by_kind(AnyWorld& world) {
  return std::tie(world.sfem_bodies, world.rhombus_bodies, world.lattice_bodies, world.cloth_bodies,
                  world.rigid_bodies);
}

struct BodyId {
  BodyKind kind = BodyKind::kLattice;
  int index = 0;
  bool operator==(const BodyId&) const = default;
};

constexpr const char* model_name(BodyKind kind) { return kModelNames[static_cast<std::size_t>(kind)]; }

/// visit(kind, bodies of the scene, bodies of the world) for every kind.
template <class AnyScene, class AnyWorld, class Visit>
void for_each_kind(AnyScene& scene, AnyWorld& world, const Visit& visit) {
  const auto of_scene = bodies_by_kind(scene);
  const auto of_world = bodies_by_kind(world);
  static_assert(std::tuple_size_v<decltype(of_world)> == kModelCount, "a name and a vector for every kind");
  [&]<std::size_t... kKind>(std::index_sequence<kKind...>) {
    (visit(BodyKind(kKind), std::get<kKind>(of_scene), std::get<kKind>(of_world)), ...);
  }
  (std::make_index_sequence<kModelCount>());
}

/// visit(id, body) for every body.
template <class AnyWorld, class Visit>
void for_each_body(AnyWorld& world, const Visit& visit) {
  for_each_kind(world, world, [&visit](BodyKind kind, auto& bodies, auto&) {
    for (std::size_t b = 0; b < bodies.size(); b++) visit(BodyId{kind, int(b)}, bodies[b]);
  });
}
/// act(id, body) for every body until the first failure, which is returned.
template <class AnyWorld, class Act>
Status try_each_body(AnyWorld& world, const Act& act) {
  Status status = Done{};
  for_each_body(world, [&](BodyId id, auto& body) {
    if (status) status = act(id, body);
  });
  return status;
}

/// visit(body) with the body's own type. The result type must be the same for all kinds.
template <std::size_t kKind = 0, class AnyWorld, class Visit>
decltype(auto) visit_body(AnyWorld& world, BodyId id, const Visit& visit) {
  auto& bodies = std::get<kKind>(bodies_by_kind(world));
  if constexpr (kKind + 1 < kModelCount)
    if (std::size_t(id.kind) != kKind) return visit_body<kKind + 1>(world, id, visit);
  TURGOR_ASSERT(std::size_t(id.kind) == kKind && std::size_t(id.index) < bodies.size(),
                "a BodyId names a body of its world");
  return visit(bodies[std::size_t(id.index)]);
}

}  // namespace turgor
