// A body of the scene as what a cloth lies on: where its surface goes in a frame, and which of the body's
// vertices bear what the cloth does to it.
#pragma once

#include <memory>
#include <vector>

#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/scene/cloth_scene.hpp"

namespace turgor {

struct World;
struct LatticeBody;

struct ClothSupport {
  BodyId body;
  std::vector<int> carrier;     // of each vertex of the surface: a lattice's slot, or the body's vertex
  std::vector<Int3> triangles;  // of the surface
  std::vector<Vec3> places;     // of its vertices at the end of the latest frame [m]
  std::shared_ptr<const cloth::MovingSurface> moving;  // in this frame: from the last one's places to these
  std::vector<contact::VertexForce> force;  // of the cloth on the body in the latest frame, by carrier [N]
};

/// Looks where the body's surface has gone in this frame.
void follow_body(const Exec& exec, ClothSupport& support, World& world);
/// Notes what a cloth did to it in its latest step; `obstacle` of its inputs.
void note_force(const cloth::State& state, int obstacle, double dt, ClothSupport& support);

/// What cloth does to a lattice in its next step.
std::vector<lattice::NodeLoad> node_loads(const LatticeBody& body);

/// What all cloths did to a body in the latest frame.
ClothPush push_on(const World& world, BodyId body);

}  // namespace turgor
