// Levels of the coarse space by aggregation. An aggregate is connected tissue in one block. On the finest
// level it is a cell or a cut-cell element; on each next level blocks have twice the side length.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

/// Connected tissue in one block of a level.
struct Aggregate {
  Int3 low;                     // lowest corner of the block, in block side lengths of its level
  std::array<int, 8> corner{};  // its eight corners: indices into CoarseLevel::position
  int parent = -1;              // index of the aggregate that contains it on the next level
  bool is_cut = false;          // true if a blade crossed it: its nodes are unknowns
};

struct CoarseLevel {
  std::vector<Aggregate> aggregates;
  std::vector<Int3> position;         // of the level's nodes, in block side lengths of the level
  std::vector<int> membership_begin;  // by node, and the end: indices into `memberships`, which lists the
                                      // next level's aggregates that contain the node
  std::vector<int> memberships;
};

/// Builds the next coarser level. A coarse block combines two blocks per side and has one aggregate per
/// connected component. Also sets the parents and memberships of `fine`.
CoarseLevel coarsen(CoarseLevel& fine);

/// Finest level: whole cells and cut-cell elements. Its nodes are slots, and slot_count + index for virtual
/// nodes.
struct FineCells {
  CoarseLevel level;
  std::vector<Real> young;  // Young's modulus of each aggregate [Pa]
  std::vector<int>
      virtual_node_slot;  // slot of each virtual node's lattice node; −1 = virtual node without elements
};
FineCells find_fine_cells(const Model& model, const State& state);

/// Largest uncut aggregate that contains a given aggregate. The default AggregateIndex if the aggregate
/// itself is cut.
AggregateIndex leaf_above(std::span<const CoarseLevel> levels, int level, int aggregate);

/// Assembles and factors the Galerkin operator of cells, loose edges, skin and inertia.
void assemble_coarse_operator(const Model& model, const State& state, std::span<const CoarseLevel> levels,
                              const FineCells& cells, CoarseSpace& space, const Exec& exec);
/// Slot at the other end of an edge.
int end_of(const Lattice& lattice, const UncoveredEdge& edge);

}  // namespace turgor::lattice
