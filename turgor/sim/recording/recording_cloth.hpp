// Cloth in a recording: its mesh at rest once, and the positions of all vertices at each snapshot, in the
// vertex order of the mesh.
#pragma once

#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Rest positions and triangles of the mesh.
Status write_body(Hdf5File& file, const ClothBody& body);
/// Error: the body has another mesh than the recorded one. Older recordings have no mesh and are not
/// compared.
Status check_body(const Hdf5File& file, const ClothBody& body);

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId id);
/// Error: another number of vertices, or a position that is not finite.
Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id);

}  // namespace turgor
