// The world: every body, every cut and every tool of a scene while they are simulated. load_world makes it
// from a scene; step moves it by one frame: blades first, then each model in turn.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/rhombus/rhombus_body.hpp"
#include "turgor/sim/bodies/sfem/load_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// An incision of the scene while it happens.
struct Cut {
  lattice::Incision blade;
  int body = 0;                            // index into World::lattice_bodies
  std::optional<lattice::BladePath> path;  // laid when the blade starts
  double done = 0;                         // fraction of the path that is cut
  int edges = 0;                           // edges cut, or nodes removed by a static region
};

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

/// Calls visit(id, body) for every body that tools can touch. This and visit_touched are the only functions
/// that list the models.
template <class AnyWorld, class Visit>
void for_each_touched(AnyWorld& world, const Visit& visit) {
  const auto all = [&visit](BodyKind kind, auto& bodies) {
    for (std::size_t b = 0; b < bodies.size(); b++) visit(BodyId{kind, int(b)}, bodies[b]);
  };
  all(BodyKind::kSfem, world.sfem_bodies);
  all(BodyKind::kRhombus, world.rhombus_bodies);
  all(BodyKind::kLattice, world.lattice_bodies);
}
/// The same while act(id, body) succeeds; the first failure else.
template <class AnyWorld, class Act>
Status try_each_touched(AnyWorld& world, const Act& act) {
  Status status = Done{};
  for_each_touched(world, [&](BodyId id, auto& body) {
    if (status) status = act(id, body);
  });
  return status;
}
/// visit(body), with the body as what it is. Cloth is not touched by tools.
template <class AnyWorld, class Visit>
decltype(auto) visit_touched(AnyWorld& world, BodyId id, const Visit& visit) {
  TURGOR_ASSERT(id.kind != BodyKind::kCloth, "tools do not touch cloth");
  const auto b = std::size_t(id.index);
  if (id.kind == BodyKind::kSfem) return visit(world.sfem_bodies[b]);
  if (id.kind == BodyKind::kRhombus) return visit(world.rhombus_bodies[b]);
  return visit(world.lattice_bodies[b]);
}
inline TouchedBody& touched_body(World& world, BodyId id) {
  return visit_touched(world, id, [](TouchedBody& body) -> TouchedBody& { return body; });
}
inline const TouchedBody& touched_body(const World& world, BodyId id) {
  return visit_touched(world, id, [](const TouchedBody& body) -> const TouchedBody& { return body; });
}
/// Is its surface kept for the tools? That of a lattice is when there are any: else it is drawn as skin
/// alone.
inline bool keeps_surface(BodyId id, const TouchedBody& body) {
  return id.kind != BodyKind::kLattice || !body.tool_indices.empty();
}
/// What tools find at rest. That of a lattice is there once a tool has come.
inline RestSurface rest_surface(const World& world, BodyId id) {
  return visit_touched(world, id, [](const auto& body) { return rest_surface(body); });
}
inline double time_of(const World& world) { return world.frame * world.dt; }

struct FrameReport {
  bool finite = true;          // false: a model's step was undone
  double seconds = 0;          // wall time
  double largest_speed = 0;    // [m/s]
  lattice::Residual residual;  // when asked for; the largest over all bodies
};

/// What a world is made for. To draw a recording, bodies stay empty: it holds their surfaces.
enum class Purpose : std::uint8_t { kSimulate, kDraw };

/// Reads or makes what the bodies are made of, builds them, and tries every blade on the body at rest.
Result<World> load_world(const Exec& exec, const Scene& scene, const BeginWork& begin = {},
                         Purpose purpose = Purpose::kSimulate);

/// One frame. Error: a blade found no skin any more.
Result<FrameReport> step(const Exec& exec, World& world, bool measure_residual = false);

/// Smallest box around the nodes of a body, along the axes of the patient frame [m].
struct BodyBox {
  Vec3d low, high;
};
BodyBox body_box(const lattice::Model& model);
/// A cut given in fractions of the body's box, in metres. A fraction that is exactly 0 or 1 means the body's
/// own surface seen from that side of the box, not the box's face.
lattice::Incision placed_blade(const lattice::Model& model, const lattice::Incision& fractions);

}  // namespace turgor
