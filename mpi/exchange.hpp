// Halo exchange over MPI during steps and cuts: implements lattice::HaloExchange. After each phase of a sweep
// a process sends one layer to one neighbor. After the even slabs, it sends its first owned layer down; after
// the odd slabs, the last one up. Projections also move the layer above their last cells, and send that one
// up. Virtual nodes are sent with their layers.
#pragma once

#include <cstdint>

#include "mpi/shares.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::mpi {

/// Totals of the exchanges during sweeps.
struct Traffic {
  std::int64_t bytes = 0, messages = 0;  // sent
  double seconds = 0;                    // wall time from the end of own work to the last byte, with waiting
  double processor_seconds = 0;          // CPU time of the same; most MPI libraries wait actively
  double least_seconds = 0;              // shortest wait in one phase; 0 without exchanges
};

/// The layers of a body in one process. The referenced objects must outlive it.
struct Subdomain {
  const Ranks& ranks;
  const Shares& shares;
  const lattice::Model& model;
  lattice::State& state;
  Traffic traffic;

  const Share& share() const { return shares.of[std::size_t(ranks.rank)]; }
};

/// CPU time of this process [s].
double processor_seconds();

lattice::HaloExchange halo_exchange_of(Subdomain& subdomain);

/// Virtual nodes of all processes, in the order of the body.
std::vector<lattice::VirtualNodeDisplacement> all_virtual_nodes(const Subdomain& subdomain);

/// Hash that equals lattice::state_hash of the whole body in one process.
std::uint64_t state_hash(const Subdomain& subdomain);

}  // namespace turgor::mpi
