// Lattice bodies in a recording: their rest shape once, and their state at each snapshot.
#pragma once

#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Hash of the CT, lattice and rest positions of the nodes.
Status write_body(Hdf5File& file, const LatticeBody& body);

Status write_state(const SnapshotOut& out, const LatticeBody& body, BodyId id);
/// Restores the state of a body whose cuts are restored. Errors: damaged data, such as a cut edge outside the
/// body.
Status read_state(const SnapshotIn& in, LatticeBody& body, BodyId id);

}  // namespace turgor
