// Cloth in a recording: where every vertex is at each snapshot, in the numbering of the mesh.
#pragma once

#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId id);
/// Error: another number of vertices, or a place that is no number.
Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id);

}  // namespace turgor
