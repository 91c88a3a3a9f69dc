// From a CT to the part of its body that a process holds. Each process reads, or paints, the slices of its
// own layers alone. What no part can know by itself is found together: what lies beside the body, by cells of
// some 3 mm of which everybody has the whole picture; which air is outside and which tissue is the body, by
// connected parts that are joined where layers of two processes meet.
#pragma once

#include "mpi/shares.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor::mpi {

struct LoadedPart {
  LatticeBody body;  // without its CT
  Shares shares;
  Grid nodes;                                   // of the whole body
  std::int64_t body_nodes = 0, free_nodes = 0;  // likewise
  std::int64_t voxels_read = 0;                 // here
};

/// Error: the same on all ranks; names the scene's place.
Result<LoadedPart> load_part(const Exec& exec, const Ranks& ranks, const LatticeScene& scene, bool is_cut);

}  // namespace turgor::mpi
