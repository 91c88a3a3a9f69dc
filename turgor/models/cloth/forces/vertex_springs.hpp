// Springs between vertices of a cloth and targets, as of attachments to other bodies, and constant forces. A
// step is implicit in the springs, as it is in those of the fabric: they may be much stiffer than the fabric.
#pragma once

#include <span>

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Force on the vertex, F = −k max(0, |d| − s) d/|d| with d = x − target, and −dF/dx.
struct VertexSpringForce {
  Vec3 force;                    // [N]
  Vec3 diagonal = {}, off = {};  // of −dF/dx: xx yy zz, xy xz yz; positive semidefinite [N/m]

  /// K a.
  Vec3 stiffness_times(Vec3 a) const {
    return {diagonal.x * a.x + off.x * a.y + off.y * a.z, off.x * a.x + diagonal.y * a.y + off.z * a.z,
            off.y * a.x + off.z * a.y + diagonal.z * a.z};
  }
};
VertexSpringForce spring_force(const VertexSpring& spring, Vec3 x);

/// Adds the springs at the positions and velocities of the state: impulses h F − h² K v to `impulse` [N·s],
/// and h² K to the matrix in `diagonal` and `off` [kg]. They have no damping, because targets move.
void add_vertex_springs(std::span<const VertexSpring> springs, const State& state, double dt,
                        Vectors& impulse, Vectors& diagonal, Vectors& off);
/// Adds the impulses h F of forces.
void add_vertex_loads(std::span<const VertexLoad> loads, double dt, Vectors& impulse);

}  // namespace turgor::cloth
