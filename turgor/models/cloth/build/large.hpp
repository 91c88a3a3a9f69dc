// Primitives that are large relative to the thickness, and the corners around them that bound the directions
// of their contacts (contact/normal_cones.hpp).
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"

namespace turgor::cloth {

/// Triangles with an edge above 1.5 thicknesses [m] and those around them, their edges, and the stars of
/// vertices in them. Slivers collide with nothing.
LargePrimitives find_large_primitives(const TriMesh& mesh, const Membrane& membrane, double thickness);

}  // namespace turgor::cloth
