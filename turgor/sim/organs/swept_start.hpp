// Start of the sweeps of a lattice that nothing fixes, under the forces that held it in the last step.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor {

struct LatticeBody;

/// Forces of other bodies on a lattice that nothing fixes, lattice frame. Without friction.
struct SweptForces {
  double free_mass = 0;   // of the lattice; 0: something fixes it [kg]
  Vec3d sum;              // [N]
  double friction = 0;    // sum of the largest friction forces [N]
  Vec3d ahead;            // motion of the other bodies in the next step, weighted with the forces [N·m]
  double magnitudes = 0;  // sum of the sizes of the forces [N]

  void add(Vec3d force, Vec3d motion);
};

/// Acceleration of a free lattice by these forces and by that of its tools [N] in the last step, besides
/// gravity (patient frame) [m/s²]. The part of the other bodies stops the approach to them and bears the
/// remaining forces, and no more: where few sweeps overestimate a force, the body would jump off, farther in
/// every frame. Across these forces, friction stops the body as far as it can. A body at rest starts where it
/// is. Started with the friction of the last step, it would slide to and fro from frame to frame.
Vec3d start_acceleration(const LatticeBody& body, const SweptForces& forces, Vec3d tools, Vec3d gravity,
                         double dt);

}  // namespace turgor
