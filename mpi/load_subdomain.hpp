// Builds the layers of a body that a process holds, from a CT. Each process reads or generates only the
// slices of its own layers. The processes determine together what depends on the whole body: surroundings of
// the body (cells of about 3 mm, gathered on all ranks), outside air, and the largest connected tissue.
// Connected components are joined across the borders of processes.
#pragma once

#include "mpi/shares.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor::mpi {

struct LoadedSubdomain {
  LatticeBody body;  // without its CT
  Shares shares;
  Grid nodes;                                   // of the whole body
  std::int64_t body_nodes = 0, free_nodes = 0;  // of the whole body
  std::int64_t voxels_read = 0;                 // by this process
};

/// Error: the same on all ranks; names the location in the scene file.
Result<LoadedSubdomain> load_subdomain(const Exec& exec, const Ranks& ranks, const LatticeScene& scene,
                                       bool is_cut);

}  // namespace turgor::mpi
