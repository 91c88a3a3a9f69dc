// Cloth in a recording: positions of all vertices at each snapshot, in the vertex order of the mesh.
#pragma once

#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId id);
/// Error: another number of vertices, or a position that is not finite.
Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id);

}  // namespace turgor
