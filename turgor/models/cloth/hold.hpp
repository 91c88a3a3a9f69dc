// Held vertices of a cloth: boundary conditions that follow a goal. A held vertex has no free mass.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Holds a vertex of the mesh at its position; it moves to its goal in each step. Error: no such vertex.
Status hold(const Model& model, State& state, int mesh_vertex);
/// Sets the position of a held vertex at the end of the next step [m]. Error: the vertex is not held.
Status move_hold(const Model& model, State& state, int mesh_vertex, Vec3 goal);
/// Frees a held vertex, which keeps its velocity.
Status release(const Model& model, State& state, int mesh_vertex);

}  // namespace turgor::cloth
