// Measurements for reports and tests: energy, momentum, hold forces, stretch, distances between layers,
// surfaces. Nothing of this is used by the step.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

struct Energy {
  double elastic = 0, kinetic = 0, potential = 0;  // potential: of gravity, 0 at the origin [J]
};
/// Elastic energy of membrane and bending, or of the springs; kinetic and potential energy [J].
Energy energy(const Model& model, const State& state, Vec3d gravity);

/// Momentum Σ m v [kg·m/s].
Vec3d momentum(const Model& model, const State& state);

/// Force of a hold on its vertex after a step of dt that changed its velocity by `change` [m/s]: m a minus
/// springs, contacts and weight [N]. Wind on the vertex is not included.
Vec3d hold_force(const Model& model, const State& state, int mesh_vertex, Vec3d gravity, Vec3d change,
                 double dt);

/// Vertices of the model that hold_force of these vertices of the mesh reads, ascending.
std::vector<int> vertices_of_hold_forces(const Model& model, std::span<const int> mesh_vertices);

/// Largest length of a spring relative to its rest length [1].
double largest_stretch(const Model& model, const State& state);

struct SelfDistance {
  double smallest = INFINITY;  // between vertices that are neither adjacent nor near each other at rest [m]
  int too_near = 0;            // such pairs closer than 0.99 of the thickness
  int crossings = 0;           // pairs of triangles that intersect
};
/// Distances between layers. Tests all pairs up to twice the thickness and all triangles, so it is slow.
/// `smallest` is infinite if there is no such pair.
SelfDistance self_distance(const Exec& exec, const Model& model, const State& state);

/// Deformed mesh in the numbering of the input mesh, with the given triangles and smooth normals.
TriMesh surface(const Model& model, const State& state, std::vector<Int3> mesh_triangles);
/// Displacement of each vertex of the input mesh from its initial position [m].
std::vector<Vec3> displacements(const Model& model, const State& state);
/// Deformed mesh in the numbering and with the triangles of the model, without normals.
TriMesh model_surface(const Model& model, const State& state);

/// Memory of a model and its state during a run [B].
std::size_t memory_bytes(const Model& model, const State& state);
/// Hash of positions and velocities; independent of the number of threads.
std::uint64_t state_hash(const Model& model, const State& state);

}  // namespace turgor::cloth
