// Layers of a garment that are closer than the thickness at rest. Their vertices are excluded from contact,
// so they may pass through each other.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"

namespace turgor::cloth {

/// Number of vertices that are closer than the thickness [m] at rest to a vertex more than three thicknesses
/// away along edges. `near`: pairs i < j that are adjacent or closer than the thickness.
int vertices_near_other_layers(const TriMesh& mesh, const NeighborLists& near, double thickness);

}  // namespace turgor::cloth
