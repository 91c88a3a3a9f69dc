// What a process that holds a part of a body asks of the others while it steps and cuts: lattice::Others over
// MPI. In every phase of a sweep one layer goes to one neighbour: after the even slabs the first own layer
// down, after the odd slabs the last one up; projections move the layer above their last cells, and send that
// up. Copies of nodes beside blades go with their layers.
#pragma once

#include <cstdint>

#include "mpi/shares.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::mpi {

/// Of what sweeps told neighbours so far.
struct Traffic {
  std::int64_t bytes = 0, messages = 0;  // sent
  double seconds = 0;                    // from the end of own work to the last byte; waiting included
  double processor_seconds = 0;          // likewise, of the processor: waiting is work for most of MPI
  double least_seconds = 0;              // of one phase, the one that waited least; 0: there was none
};

/// All of these outlive what is made of them.
struct PartOfBody {
  const Ranks& ranks;
  const Shares& shares;
  const lattice::Model& model;
  lattice::State& state;
  Traffic traffic;

  const Share& share() const { return shares.of[std::size_t(ranks.rank)]; }
};

/// Of this process, since it began [s].
double processor_seconds();

lattice::HaloExchange others_of(PartOfBody& part);

/// Copies of nodes in the body's order, of all processes.
std::vector<lattice::VirtualNodeShift> all_copies(const PartOfBody& part);

/// As lattice::state_hash of the whole body in one process.
std::uint64_t state_hash(const PartOfBody& part);

}  // namespace turgor::mpi
