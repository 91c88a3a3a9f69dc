// The world: every body, every cut and every tool of a scene while they are simulated. load_world makes it
// from a scene; step moves it by one frame: blades first, then each model in turn (sim/scene/body_id.hpp
// lists them). How it looks is told by sim/snapshot.hpp, how a whole run goes by sim/run.hpp.
#pragma once

#include <type_traits>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/bodies/lattice/cut.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World {
  Vec3d gravity;  // patient frame [m/s²]
  double dt = 0;  // of a frame [s]
  int frame = 0;  // finished
  std::vector<LatticeBody> lattice_bodies;
  std::vector<SfemBody> sfem_bodies;
  std::vector<RhombusBody> rhombus_bodies;
  std::vector<ClothBody> cloth_bodies;
  std::vector<Cut> cuts;
  std::vector<TouchingTool> tools;
};

inline double time_of(const World& world) { return world.frame * world.dt; }

/// Can tools touch bodies of this kind?
template <class Body>
constexpr bool is_touched = std::is_base_of_v<TouchedBody, std::remove_cvref_t<Body>>;

/// visit(id, body) for every body that tools can touch.
template <class AnyWorld, class Visit>
void for_each_touched(AnyWorld& world, const Visit& visit) {
  for_each_body(world, [&visit](BodyId id, auto& body) {
    if constexpr (is_touched<decltype(body)>) visit(id, body);
  });
}
TouchedBody& touched_body(World& world, BodyId id);
const TouchedBody& touched_body(const World& world, BodyId id);
/// What tools find at rest; nothing where they do not touch. That of a lattice is there once a tool has come.
RestSurface rest_surface(const World& world, BodyId id);

/// Reads or makes what the bodies are made of, builds them, and tries every blade on the body at rest.
Result<World> load_world(const Exec& exec, const Scene& scene, const BeginWork& begin = {},
                         Purpose purpose = Purpose::kSimulate);

/// What a person should know of how a world was made: sentences, each with the body it is about.
std::vector<std::string> notes_of(const World& world);

/// One frame. Error: a blade found no skin any more.
Result<FrameReport> step(const Exec& exec, World& world, bool measure_residual = false);

/// Equal for equal bits in all bodies and in all forces that tools felt, however many threads there are.
std::uint64_t state_hash(const World& world);

}  // namespace turgor
