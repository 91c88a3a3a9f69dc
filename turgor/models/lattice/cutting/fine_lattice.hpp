// The fine lattice: every cell in equal parts, about as many a side as the CT has voxels in it. What blades
// cut are its edges, of the same seven families; what cells fall apart into, and what is drawn, is found on
// it. Springs, cells and their unknowns stay those of the lattice.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

constexpr int kMostParts = 6;
/// Places in a cell, 0 … parts along each axis, fit into this.
constexpr int kMostPlaces = (kMostParts + 1) * (kMostParts + 1) * (kMostParts + 1);

struct FineLattice {
  Lattice cells;
  Int3 parts;  // of a cell, along each axis
  Int3 size;   // fine nodes
};

inline FineLattice fine_lattice(const Model& model) {
  const Int3 parts = min(max(model.params.block, Int3{2, 2, 2}), Int3{kMostParts, kMostParts, kMostParts});
  return {model.lattice, parts, hadamard(model.lattice.size - Int3{1, 1, 1}, parts) + Int3{1, 1, 1}};
}

constexpr bool contains(const FineLattice& f, Int3 p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < f.size.x && p.y < f.size.y && p.z < f.size.z;
}
constexpr std::uint64_t fine_index(const FineLattice& f, Int3 p) {
  return (std::uint64_t(p.z) * std::uint64_t(f.size.y) + std::uint64_t(p.y)) * std::uint64_t(f.size.x) +
         std::uint64_t(p.x);
}
/// The cell that a fine node, and the edges that start at it, are counted to.
constexpr Int3 cell_of(const FineLattice& f, Int3 p) {
  return min(Int3{p.x / f.parts.x, p.y / f.parts.y, p.z / f.parts.z}, f.cells.size - Int3{2, 2, 2});
}
constexpr Int3 first_of_cell(const FineLattice& f, Int3 cell) { return hadamard(cell, f.parts); }
/// The number of a place in its cell.
constexpr int place_in_cell(const FineLattice& f, Int3 local) {
  return local.x + (f.parts.x + 1) * (local.y + (f.parts.y + 1) * local.z);
}
constexpr int places_of_cell(const FineLattice& f) {
  return (f.parts.x + 1) * (f.parts.y + 1) * (f.parts.z + 1);
}
/// Where a fine node is in the CT, in steps of the lattice.
inline Vec3d lattice_index(const FineLattice& f, Int3 p) {
  return {double(p.x) / f.parts.x, double(p.y) / f.parts.y,
          double(p.z + f.cells.first * f.parts.z) / f.parts.z};
}

/// Calls visit(local) for all places of a cell.
template <class Visit>
void for_places(const FineLattice& f, const Visit& visit) {
  for (int z = 0; z <= f.parts.z; z++)
    for (int y = 0; y <= f.parts.y; y++)
      for (int x = 0; x <= f.parts.x; x++) visit(Int3{x, y, z});
}
constexpr bool in_cell(const FineLattice& f, Int3 local) {
  return local.x >= 0 && local.y >= 0 && local.z >= 0 && local.x <= f.parts.x && local.y <= f.parts.y &&
         local.z <= f.parts.z;
}

/// Calls visit(cell) for the cells that a fine edge, or a fine node (a = b), lies in, or on their borders.
template <class Visit>
void for_cells_of_edge(const FineLattice& f, Int3 a, Int3 b, const Visit& visit) {
  Int3 low, high;
  for (int axis = 0; axis < 3; axis++) {
    const int first = std::min(a[axis], b[axis]), last = std::max(a[axis], b[axis]), parts = f.parts[axis];
    low[axis] = std::max(0, (last + parts - 1) / parts - 1);
    high[axis] = std::min(f.cells.size[axis] - 2, first / parts);
  }
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) visit(Int3{i, j, k});
}

/// The lower end of a cut edge.
inline Int3 fine_node(const FineLattice& f, const CutEdge& edge) {
  return first_of_cell(f, slot_node(f.cells, edge.slot)) +
         Int3{edge.part & 7, edge.part >> 3 & 7, edge.part >> 6};
}
/// The cut edge of a family from a fine node, of which nothing else is known yet.
inline CutEdge cut_edge_at(const FineLattice& f, Int3 node, int family) {
  const Int3 cell = cell_of(f, node), local = node - first_of_cell(f, cell);
  return {.slot = node_slot(f.cells, cell),
          .part = local.x + 8 * local.y + 64 * local.z,
          .family = std::uint8_t(family)};
}
constexpr std::uint64_t fine_edge_key(const FineLattice& f, Int3 node, int family) {
  return fine_index(f, node) * 8 + std::uint64_t(family);
}

/// Weights of a cell's eight corners, at coordinates from 0 to 1 in it.
template <class T>
constexpr std::array<T, 8> trilinear(Vec<T> at) {
  std::array<T, 8> weight{};
  for (int c = 0; c < 8; c++)
    weight[std::size_t(c)] =
        (c & 1 ? at.x : 1 - at.x) * (c >> 1 & 1 ? at.y : 1 - at.y) * (c >> 2 ? at.z : 1 - at.z);
  return weight;
}

}  // namespace turgor::lattice
