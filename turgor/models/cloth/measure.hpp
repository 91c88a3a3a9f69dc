// What reports say about a cloth: energy, momentum, how stretched it is, and whether it keeps out of itself.
#pragma once

#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

struct Energy {
  double elastic = 0, kinetic = 0, potential = 0;  // potential: of gravity, 0 at the origin [J]
};
Energy energy(const Model& model, const State& state, Vec3d gravity);

/// Σ m v [kg·m/s].
Vec3d momentum(const Model& model, const State& state);

/// What holds a held vertex of the mesh after a step of dt at the end of which it goes faster by `change`
/// [m/s]: all that its springs, contacts and weight leave over [N]. The air on it is left out.
Vec3d hold_force(const Model& model, const State& state, int mesh_vertex, Vec3d gravity, Vec3d change,
                 double dt);

/// Longest spring, by its rest length [1].
double largest_stretch(const Model& model, const State& state);

struct SelfDistance {
  double smallest = INFINITY;  // of two vertices that are neither adjacent nor near at rest [m]
  int too_near = 0;            // such pairs closer than 0.99 of the thickness
  int crossings = 0;           // pairs of triangles that pass through each other
};
/// Looks at all pairs up to twice the thickness (`smallest` stays infinite when there are none) and at all
/// triangles: slow, for reports.
SelfDistance self_distance(const Exec& exec, const Model& model, const State& state);

}  // namespace turgor::cloth
