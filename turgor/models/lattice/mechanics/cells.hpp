// Cells of solid tissue. A cell is whole if its eight corners are body and none of its nineteen edges is cut;
// whole cells are solid elements. An edge that no whole cell contains is loose: it becomes a spring, so that
// no node is without elements. Loose edges occur at stairs of the surface and next to two cuts.
#pragma once

#include <memory>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Filled part of every cell, by its lowest node, i fastest. Empty: a cell is full if its corners are body.
struct CellFill {
  std::vector<float> fraction;  // filled fraction, with the tiny fractions of neighbors; 0 = no element [1]
  std::vector<CellCenter> center;  // of the filled part
};

/// Fills Anatomy::cell_young, Anatomy::cell_center and VbdTables::incident_elements.
void build_cells(const Exec& exec, const CellFill& fill, Model& model);

/// True if an edge at this slot is in no whole cell. False for slots without tissue.
bool has_loose_edge(const Model& model, int slot);

/// Bits of the edge families that start at corner n and stay in the cell.
constexpr std::uint8_t edges_from_corner(int n) {
  std::uint8_t bits = 0;
  for (int f = 0; f < kFamilyCount; f++) {
    const Int3 end = cell_corner(n) + kFamilies[std::size_t(f)];
    if (end.x <= 1 && end.y <= 1 && end.z <= 1) bits |= std::uint8_t(1u << f);
  }
  return bits;
}

/// edges_from_corner for a corner known at run time. It needs no table of families, which a GPU lacks.
constexpr std::uint8_t edges_from(int n) {
  constexpr std::uint64_t kEdges = [] {
    std::uint64_t all = 0;
    for (int c = 0; c < 8; c++) all |= std::uint64_t(edges_from_corner(c)) << 8 * c;
    return all;
  }();
  return std::uint8_t(kEdges >> 8 * n);
}

/// True if a cell contains both its corner n and the node at `offset` from that corner.
constexpr bool cell_contains(int n, Int3 offset) {
  const Int3 end = cell_corner(n) + offset;
  return end.x >= 0 && end.y >= 0 && end.z >= 0 && end.x <= 1 && end.y <= 1 && end.z <= 1;
}

/// True if a cell, given by its lowest node, is whole and uncut in this state.
bool is_whole_cell(const Model& model, const Cuts& cuts, Int3 cell);
/// True if a whole cell or cut elements of a cell contain the edge from a node along `offset`.
bool is_edge_covered(const Model& model, const Cuts& cuts, Int3 node, Int3 offset);

/// The 27 nodes of the eight cells around a node, indexed by 1 + offset.
constexpr int kBlockNodes = 27;
constexpr int block_index(Int3 offset) { return offset.x + 1 + 3 * (offset.y + 1) + 9 * (offset.z + 1); }
struct NodeBlock {
  int offset[kBlockNodes];  // [slots]
};
NodeBlock node_block(const Lattice& lattice, int parity);

/// Gathers forces and Hessians of cells and loose edges for the nodes of [slot, slot + count). It writes
/// whole vectors; the last lanes are unused.
struct CellLawView;
struct SolidRow {
  const Model& model;
  const std::uint8_t* row_cut;
  NodeArrays nodes;
  const Real* young;            // of cells, Anatomy::cell_young
  const std::uint32_t* center;  // Anatomy::cell_center; null without partial cells
  SolidLaw law;
  NodeBlock block[2];
  Neighbors neighbors[2];
  std::shared_ptr<const CellLawView> laws;  // null: all cells follow `law`

  SolidRow(const Model& m, State& s);
  void gather(int parity, int slot, int count, SystemBuffer& out) const;
};

}  // namespace turgor::lattice
