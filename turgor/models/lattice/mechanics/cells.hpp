// The cells of a lattice of solid tissue. A cell is whole when its eight corners are body and none of its
// nineteen edges is cut; whole cells are solid. An edge that no whole cell holds, at a step of the surface or
// beside two cuts, is a spring, so that no node hangs on nothing.
#pragma once

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Young's modulus of the cells, and what is around each group of slots.
void build_cells(const Exec& exec, Model& model);

/// The edges of family f that start at corner n and stay in the cell, as bits.
constexpr std::uint8_t edges_from_corner(int n) {
  std::uint8_t bits = 0;
  for (int f = 0; f < kFamilyCount; f++) {
    const Int3 end = cell_corner(n) + kFamilies[std::size_t(f)];
    if (end.x <= 1 && end.y <= 1 && end.z <= 1) bits |= std::uint8_t(1u << f);
  }
  return bits;
}

/// The same of a corner that is not known before, where the table of families is not at hand: on a GPU.
constexpr std::uint8_t edges_from(int n) {
  constexpr std::uint64_t kEdges = [] {
    std::uint64_t all = 0;
    for (int c = 0; c < 8; c++) all |= std::uint64_t(edges_from_corner(c)) << 8 * c;
    return all;
  }();
  return std::uint8_t(kEdges >> 8 * n);
}

/// Does a cell hold both its corner n and the node at `offset` from it?
constexpr bool cell_holds(int n, Int3 offset) {
  const Int3 end = cell_corner(n) + offset;
  return end.x >= 0 && end.y >= 0 && end.z >= 0 && end.x <= 1 && end.y <= 1 && end.z <= 1;
}

/// Is a cell, known by its lowest node, whole and not parted as the body is cut now?
bool is_whole_now(const Model& model, const State& state, Int3 cell);
/// Does a whole cell, or its parts, hold the edge from a node along `offset`?
bool is_held_now(const Model& model, const State& state, Int3 node, Int3 offset);

/// The twenty-seven nodes of the eight cells around a node, by 1 + offset.
constexpr int kBlockNodes = 27;
constexpr int block_index(Int3 offset) { return offset.x + 1 + 3 * (offset.y + 1) + 9 * (offset.z + 1); }
struct NodeBlock {
  int offset[kBlockNodes];  // in slots
};
NodeBlock node_block(const Lattice& lattice, int parity);

/// What the cells, and the springs where there are no whole ones, ask of the nodes of [slot, slot + count).
/// Writes whole vectors, of which the last lanes are not used.
struct SolidRow {
  const Model& model;
  const std::uint8_t* row_cut;
  NodeArrays nodes;
  const Real* young;  // of cells
  SolidLaw law;
  NodeBlock block[2];
  Neighbors neighbors[2];

  SolidRow(const Model& m, State& s);
  void gather(int parity, int slot, int count, SystemBuffer& out) const;
};

}  // namespace turgor::lattice
