// The levels that a coarse space is made of: grains are what holds together in a block, first cells and parts
// of cells, then blocks of two of these a side.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

/// What holds together in one block of a level.
struct Aggregate {
  Int3 low;                     // in steps of its level
  std::array<int, 8> corner{};  // nodes of its level
  int parent = -1;              // grain of the next level
  bool is_parted = false;       // a blade went through it: its nodes are unknowns themselves
};

struct CoarseLevel {
  std::vector<Aggregate> aggregates;
  std::vector<Int3> place;      // of the nodes, in steps of the level
  std::vector<int> lies_begin;  // by node, in lies_in: the grains of the next level that it lies in
  std::vector<int> lies_in;
};

/// Joins grains to blocks of two a side: as many to a block as parts of it hold together.
CoarseLevel coarsen(CoarseLevel& fine);

/// The cells and parts of cells of a body, as they are cut; a node is a slot, or slot_count + number of a
/// copy.
struct FineCells {
  CoarseLevel level;
  std::vector<Real> young;     // of the grains [Pa]
  std::vector<int> copy_slot;  // by copy: the node that it is one of, −1 = bears nothing
};
FineCells find_cells(const Model& model, const State& state);

/// The largest block around a grain that no blade went through.
Leaf leaf_above(std::span<const CoarseLevel> levels, int level, int grain);

/// Adds the stiffness of cells, loose edges, skin and inertia in the space, and factors it.
void factor_coarse_space(const Model& model, const State& state, std::span<const CoarseLevel> levels,
                         const FineCells& cells, CoarseSpace& space);
/// The other end of an edge.
int end_of(const Lattice& lattice, const LooseEdge& edge);

}  // namespace turgor::lattice
