// The world: every body, every cut and every tool of a scene while they are simulated. load_world makes it
// from a scene; step moves it by one frame: blades first, then each model in turn.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/cloth_body.hpp"
#include "turgor/sim/lattice_body.hpp"
#include "turgor/sim/load_organ.hpp"
#include "turgor/sim/organ.hpp"
#include "turgor/sim/rhombus_organ.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// An incision of the scene while it happens.
struct Cut {
  lattice::Incision blade;
  int body = 0;                            // index into World::lattices
  std::optional<lattice::BladePath> path;  // laid when the blade starts
  double done = 0;                         // fraction of the path that is cut
  int edges = 0;                           // edges cut, or nodes removed by a static region
};

struct World {
  Vec3d gravity;  // patient frame [m/s²]
  double dt = 0;  // of a frame [s]
  int frame = 0;  // finished
  std::vector<LatticeBody> lattices;
  std::vector<Cut> cuts;
  std::vector<Organ> organs;
  std::vector<RhombusOrgan> rhombi;
  std::vector<TouchingTool> tools;
  std::vector<ClothBody> clothes;
};
/// Bodies that are there to be touched, organs of sfem and rhombus.
inline std::size_t organ_count(const World& world) { return world.organs.size() + world.rhombi.size(); }
/// Bodies of all models that tools can touch: those of sfem, of rhombus, then lattices.
inline std::size_t touched_count(const World& world) { return organ_count(world) + world.lattices.size(); }
inline const TouchedOrgan& touched_organ(const World& world, std::size_t index) {
  if (index < world.organs.size()) return world.organs[index];
  if (index < organ_count(world)) return world.rhombi[index - world.organs.size()];
  return world.lattices[index - organ_count(world)];
}
/// Is its surface kept for the tools? That of a lattice is when there are any.
inline bool keeps_surface(const World& world, std::size_t index) {
  return index < organ_count(world) || !touched_organ(world, index).tool_indices.empty();
}
inline TouchedOrgan& touched_organ(World& world, std::size_t index) {
  return const_cast<TouchedOrgan&>(touched_organ(std::as_const(world), index));
}
inline double time_of(const World& world) { return world.frame * world.dt; }

/// What tools find at rest. That of a lattice is there once a tool has come.
RestSurface rest_surface(const World& world, std::size_t body);

struct FrameReport {
  bool finite = true;          // false: a model's step was undone
  double seconds = 0;          // wall time
  double largest_speed = 0;    // [m/s]
  lattice::Residual residual;  // when asked for; the largest over all bodies
};

/// What a world is made for. To draw a recording, organs stay empty: it holds their surfaces.
enum class Purpose : std::uint8_t { kSimulate, kDraw };

/// Reads or makes the CTs and the organs, builds the bodies, and tries every blade on the body at rest.
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
