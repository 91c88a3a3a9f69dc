// Motion of a body as a whole: that of a rigid body with the momentum, the angular momentum and the inertia
// of its moving nodes. Lattice frame.
#pragma once

#include "turgor/models/lattice/model/model.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct WholeMotion {
  double mass = 0;  // of the moving nodes [kg]
  Vec3d center;     // of mass [m]
  Vec3d velocity;   // of the center [m/s]
  Vec3d spin;       // angular velocity [rad/s]
  // about the center; 0 if all nodes are on a line [1/(kg m²)]
  Mat3d inverse_inertia{{{}, {}, {}}};
};
WholeMotion whole_motion(const Model& model, const State& state);

/// Present position of a node [m].
Vec3d node_position(const Model& model, const State& state, int slot);

/// Adds a velocity of the center and an angular velocity to the moving nodes [m/s] [rad/s].
void add_velocity(const Model& model, Vec3d center, Vec3d velocity, Vec3d spin, State& state);

}  // namespace turgor::lattice
