// Body of the scene that supports a cloth: motion of its surface in a frame, and contact forces on its
// vertices.
#pragma once

#include <memory>
#include <vector>

#include "turgor/contact/coupling.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/scene/cloth_scene.hpp"

namespace turgor {

struct World;
struct LatticeBody;

struct ClothSupport {
  BodyId body;
  std::vector<int> carrier;     // by surface vertex: slot of a lattice of whole cells, else the vertex
  std::vector<Int3> triangles;  // of the surface
  std::vector<Vec3> positions;  // at the end of the latest frame [m]
  std::shared_ptr<const cloth::MovingSurface>
      moving;  // motion in this frame: from the previous positions to the present ones
  std::vector<contact::VertexForce> force;  // on the body in the latest frame, by slot or vertex [N]
  // of a free body (free_support.hpp), about its center of mass
  contact::RigidLoad pressing;                // load on a rigid body in the latest frame
  contact::RigidLoad wrench;                  // relaxed load on a rigid body in the next frame
  std::vector<contact::VertexForce> relaxed;  // relaxed force on other bodies in the next frame [N]
};

/// Updates the surface to its position in this frame. `is_free`: the cloth moves the body.
void update_support(const Exec& exec, ClothSupport& support, bool is_free, World& world);
/// Records the contact forces of the latest cloth step; `obstacle` is the index in its inputs.
void record_force(const cloth::State& state, int obstacle, double dt, ClothSupport& support);

/// Loads of cloth on a lattice in its next step.
std::vector<lattice::NodeLoad> node_loads(const LatticeBody& body);

/// Forces of all cloth on a body in the latest frame.
ClothForces cloth_forces_on(const World& world, BodyId body);

}  // namespace turgor
