// Layers of a garment that lie nearer to each other than its thickness before anything moves: their vertices
// are never in contact, and pass through each other unseen.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {

/// How many vertices lie, at rest, nearer than the thickness [m] to one that is farther than three
/// thicknesses away along the mesh's edges. `near`: pairs i < j that are adjacent or nearer.
int vertices_near_other_layers(const TriMesh& mesh, const NeighborLists& near, double thickness);

}  // namespace turgor::cloth
