// World: all bodies, cuts and tools of a scene during simulation. load_world builds it from a scene. step
// advances it by one frame: first blades, then each model (sim/scene/body_id.hpp lists them). See
// sim/snapshot.hpp for drawing and sim/run.hpp for whole runs.
#pragma once

#include <type_traits>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/bodies/lattice/cut.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/lattice/suture.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"
#include "turgor/sim/bodies/rigid/rigid_body.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/frame.hpp"
#include "turgor/sim/loading.hpp"
#include "turgor/sim/organs/coupling.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World {
  Vec3d gravity;  // patient frame [m/s²]
  double dt = 0;  // duration of a frame [s]
  int frame = 0;  // finished frames
  std::vector<LatticeBody> lattice_bodies;
  std::vector<SfemBody> sfem_bodies;
  std::vector<RhombusBody> rhombus_bodies;
  std::vector<ClothBody> cloth_bodies;
  std::vector<RigidBody> rigid_bodies;
  std::vector<Cut> cuts;
  std::vector<Suture> sutures;
  std::vector<TouchingTool> tools;
  Coupling coupling;                     // attachments of bodies, and contact between them
  std::vector<std::string> scene_notes;  // Scene::notes
};

inline double time_of(const World& world) { return world.frame * world.dt; }

/// True if tools can touch bodies of this kind.
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
/// Rest surface for tools, empty if they cannot touch the body. That of a lattice exists once it has a tool.
RestSurface rest_surface(const World& world, BodyId id);

/// Loads or generates the inputs of all bodies, builds the bodies, and tests every blade on the body at rest.
Result<World> load_world(const Exec& exec, const Scene& scene, const BeginWork& begin = {},
                         Purpose purpose = Purpose::kSimulate);

/// Notes for the user about loading: sentences, each with its body.
std::vector<std::string> notes_of(const World& world);

/// Steps one frame. Error: a blade left the skin.
Result<FrameReport> step(const Exec& exec, World& world, bool measure_residual = false);

/// Hash of all bodies and of all tool forces. Equal hashes mean equal bits, for any number of threads.
std::uint64_t state_hash(const World& world);

}  // namespace turgor
