// Calm rows of a step (VBD with sleep and a coarse correction). The first sweep takes all rows that are
// awake. A later sweep leaves out a row if the last sweep moved no node of it or of its neighbors farther
// than a fifth of the distance below which nodes sleep: sweeps have nothing to do there, and the coarse
// correction moves the row. Rows at cuts and at springs are never calm. Chosen from earlier sweeps only, so
// that results do not depend on threads.
#pragma once

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Largest displacement of a node in a sweep of a calm row, over that of a sleeping node in a step
/// (docs/performance.md).
constexpr double kCalmShare = 0.2;

/// Marks by row of the storage; empty before the first sweep of a step.
struct CalmRows {
  std::vector<std::uint8_t> swept;    // 1 = taken by the present sweep
  std::vector<std::uint8_t> visited;  // 1 = taken by a sweep of this step
  std::vector<std::uint8_t> stirred;  // 1 = a node moved farther than a calm row's in the last sweep
};

/// Displacements of the nodes of a chunk before they are moved.
struct ChunkBefore {
  Real x[kLanes], y[kLanes], z[kLanes];

  void copy(const NodeArrays& n, int slot, int count) {
    for (int i = 0; i < count; i++) x[i] = n.ux[slot + i], y[i] = n.uy[slot + i], z[i] = n.uz[slot + i];
  }
  /// True if a node moved farther than a distance, whose square is given, or is not finite.
  bool has_moved(const NodeArrays& n, int slot, int count, Real distance2) const {
    Real beyond = 0;
    for (int i = 0; i < count; i++) {
      const Real dx = n.ux[slot + i] - x[i], dy = n.uy[slot + i] - y[i], dz = n.uz[slot + i] - z[i];
      const Real d2 = dx * dx + dy * dy + dz * dz;
      beyond = d2 <= distance2 ? beyond : Real(1);
    }
    return beyond != 0;
  }
};

/// Chooses the rows of the next sweep.
void choose_swept_rows(const Model& model, const State& state, const Inputs& inputs, CalmRows& rows);

}  // namespace turgor::lattice
