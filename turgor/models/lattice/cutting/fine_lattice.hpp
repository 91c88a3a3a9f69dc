// Fine lattice: every cell is divided into 2 to 6 sub-cells per side, about one per voxel. Its edges belong
// to the same seven families as those of the coarse lattice, and blades cut them. Fragments and the drawn
// surface are found on the fine lattice. Springs, cells and unknowns remain on the coarse lattice.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

constexpr int kMaxSubdivisions = 6;
/// Largest number of sub-lattice nodes of a cell, including its border.
constexpr int kMaxSubNodes = (kMaxSubdivisions + 1) * (kMaxSubdivisions + 1) * (kMaxSubdivisions + 1);

struct FineLattice {
  Lattice cells;
  Int3 subdivisions;  // of a cell, along each axis
  Int3 size;          // fine nodes along each axis
};

inline FineLattice fine_lattice(const Model& model) {
  const Int3 subdivisions =
      min(max(model.params.block, Int3{2, 2, 2}), Int3{kMaxSubdivisions, kMaxSubdivisions, kMaxSubdivisions});
  return {model.anatomy.lattice, subdivisions,
          hadamard(model.anatomy.lattice.size - Int3{1, 1, 1}, subdivisions) + Int3{1, 1, 1}};
}

constexpr bool contains(const FineLattice& f, Int3 p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < f.size.x && p.y < f.size.y && p.z < f.size.z;
}
constexpr std::uint64_t fine_index(const FineLattice& f, Int3 p) {
  return (std::uint64_t(p.z) * std::uint64_t(f.size.y) + std::uint64_t(p.y)) * std::uint64_t(f.size.x) +
         std::uint64_t(p.x);
}
/// Inverse of fine_index.
constexpr Int3 fine_position(const FineLattice& f, std::uint64_t index) {
  const auto x = std::uint64_t(f.size.x), y = std::uint64_t(f.size.y);
  return {int(index % x), int(index / x % y), int(index / x / y)};
}
/// Entry of Cuts::excised: sub-lattice node of a cell.
constexpr std::uint64_t excised_key(int slot, int sub_node) {
  return std::uint64_t(slot) * 1024 + std::uint64_t(sub_node);
}
/// Cell that owns a fine node and the edges that start at it.
constexpr Int3 cell_of(const FineLattice& f, Int3 p) {
  return min(Int3{p.x / f.subdivisions.x, p.y / f.subdivisions.y, p.z / f.subdivisions.z},
             f.cells.size - Int3{2, 2, 2});
}
constexpr Int3 first_of_cell(const FineLattice& f, Int3 cell) { return hadamard(cell, f.subdivisions); }
/// Index of a sub-lattice node in its cell.
constexpr int sub_index(const FineLattice& f, Int3 local) {
  return local.x + (f.subdivisions.x + 1) * (local.y + (f.subdivisions.y + 1) * local.z);
}
constexpr int sub_node_count(const FineLattice& f) {
  return (f.subdivisions.x + 1) * (f.subdivisions.y + 1) * (f.subdivisions.z + 1);
}
/// Rest position of a fine node [cells].
inline Vec3d lattice_index(const FineLattice& f, Int3 p) {
  return {double(p.x) / f.subdivisions.x, double(p.y) / f.subdivisions.y,
          double(p.z + f.cells.first * f.subdivisions.z) / f.subdivisions.z};
}

/// Calls visit(local) for all sub-lattice nodes of a cell.
template <class Visit>
void for_sub_nodes(const FineLattice& f, const Visit& visit) {
  for (int z = 0; z <= f.subdivisions.z; z++)
    for (int y = 0; y <= f.subdivisions.y; y++)
      for (int x = 0; x <= f.subdivisions.x; x++) visit(Int3{x, y, z});
}
constexpr bool in_cell(const FineLattice& f, Int3 local) {
  return local.x >= 0 && local.y >= 0 && local.z >= 0 && local.x <= f.subdivisions.x &&
         local.y <= f.subdivisions.y && local.z <= f.subdivisions.z;
}

/// Calls visit(cell) for all cells that contain a fine edge or, if a = b, a fine node, in the interior or on
/// the border.
template <class Visit>
void for_cells_of_edge(const FineLattice& f, Int3 a, Int3 b, const Visit& visit) {
  Int3 low, high;
  for (int axis = 0; axis < 3; axis++) {
    const int first = std::min(a[axis], b[axis]), last = std::max(a[axis], b[axis]),
              subdivisions = f.subdivisions[axis];
    low[axis] = std::max(0, (last + subdivisions - 1) / subdivisions - 1);
    high[axis] = std::min(f.cells.size[axis] - 2, first / subdivisions);
  }
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++) visit(Int3{i, j, k});
}

/// Lower end of a cut edge.
inline Int3 fine_node(const FineLattice& f, const CutEdge& edge) {
  return first_of_cell(f, slot_node(f.cells, edge.slot)) +
         Int3{edge.sub_index & 7, edge.sub_index >> 3 & 7, edge.sub_index >> 6};
}
/// Cut edge of a family that starts at a fine node; all other fields are unset.
inline CutEdge cut_edge_at(const FineLattice& f, Int3 node, int family) {
  TURGOR_CHECK(is_index(family, kFamilyCount), "a cut edge belongs to one of the seven families");
  const Int3 cell = cell_of(f, node), local = node - first_of_cell(f, cell);
  return {.slot = node_slot(f.cells, cell),
          .sub_index = local.x + 8 * local.y + 64 * local.z,
          .family = std::uint8_t(family)};
}
constexpr std::uint64_t fine_edge_key(const FineLattice& f, Int3 node, int family) {
  return fine_index(f, node) * 8 + std::uint64_t(family);
}

/// Trilinear weights of a cell's eight corners, at cell coordinates from 0 to 1.
template <class T>
constexpr std::array<T, 8> trilinear(Vec<T> at) {
  std::array<T, 8> weight{};
  for (int c = 0; c < 8; c++)
    weight[std::size_t(c)] =
        (c & 1 ? at.x : 1 - at.x) * (c >> 1 & 1 ? at.y : 1 - at.y) * (c >> 2 ? at.z : 1 - at.z);
  return weight;
}

}  // namespace turgor::lattice
