// The lattice: nodes on a regular grid, with every cell split into six Kuhn tetrahedra around its main
// diagonal. All edges then belong to seven families of constant offset, so that no index lists are needed.
//
// Storage. Nodes of one row (fixed j, k) are stored as two halves, even i then odd i, and rows are surrounded
// by a border of unused rows. This has two consequences. The two ends of every edge family are contiguous
// runs of memory (plain SIMD). Every neighbor of every node has a slot, so that loops need no tests at the
// border. Slots without a node have zero inverse mass and zero stiffness.
#pragma once

#include <array>

#include "turgor/core/vec.hpp"

namespace turgor {

struct Lattice {
  Int3 size;     // nodes along i, j, k
  Vec3 spacing;  // distance of neighboring nodes [m]
  int half{};    // slots in half a row
  int first{};   // distributed bodies: layers of the body before this lattice's first

  friend bool operator==(const Lattice&, const Lattice&) = default;
};

constexpr int kFamilyCount = 7;
/// Offsets of the seven edge families: three axes, three face diagonals, the body diagonal.
constexpr std::array<Int3, kFamilyCount> kFamilies = {Int3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0},
                                                      {1, 0, 1},     {0, 1, 1}, {1, 1, 1}};

/// Corner n of a cell is its lowest node plus (n & 1, n >> 1 & 1, n >> 2).
constexpr int kCellCorners = 8;
constexpr Int3 cell_corner(int n) { return {n & 1, n >> 1 & 1, n >> 2}; }
constexpr int corner_of(Int3 offset) { return offset.x + 2 * offset.y + 4 * offset.z; }

/// Corner offsets of the six Kuhn tetrahedra of a cell, each a path from (0,0,0) to (1,1,1), axis by axis.
/// Odd permutations of the axes have their middle corners swapped, so that all volumes are positive.
constexpr std::array<std::array<Int3, 4>, 6> kKuhnTets = {{
    {Int3{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}},  // x y z
    {Int3{0, 0, 0}, {1, 0, 1}, {1, 0, 0}, {1, 1, 1}},  // x z y
    {Int3{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 1, 1}},  // y x z
    {Int3{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {1, 1, 1}},  // y z x
    {Int3{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}},  // z x y
    {Int3{0, 0, 0}, {0, 1, 1}, {0, 0, 1}, {1, 1, 1}},  // z y x
}};

/// `size` is at least 2 nodes along each axis.
constexpr Lattice make_lattice(Int3 size, Vec3 spacing) {
  const int even = (size.x + 1) / 2;
  return {.size = size, .spacing = spacing, .half = (even + 1 + 7) / 8 * 8};
}
constexpr int row_stride(const Lattice& l) { return 2 * l.half; }
constexpr int layer_stride(const Lattice& l) { return (l.size.y + 2) * row_stride(l); }
/// Slots that loops may read beyond a run of nodes, to work on whole vectors.
constexpr int kSpareSlots = 16;
/// Slots to allocate for one value per node.
constexpr int slot_count(const Lattice& l) { return (l.size.z + 2) * layer_stride(l) + kSpareSlots; }
constexpr int node_count(const Lattice& l) { return l.size.x * l.size.y * l.size.z; }
/// First slot of row (j, k); -1 and size are the border.
constexpr int row_slot(const Lattice& l, int j, int k) {
  return (k + 1) * layer_stride(l) + (j + 1) * row_stride(l);
}
constexpr int node_slot(const Lattice& l, int i, int j, int k) {
  return row_slot(l, j, k) + (i & 1) * l.half + (i >> 1);
}
constexpr int node_slot(const Lattice& l, Int3 p) { return node_slot(l, p.x, p.y, p.z); }
/// Node of a slot; the slot must have one.
constexpr Int3 slot_node(const Lattice& l, int slot) {
  const int column = slot % row_stride(l), odd = column >= l.half ? 1 : 0;
  return {2 * (column - odd * l.half) + odd, slot / row_stride(l) % (l.size.y + 2) - 1,
          slot / layer_stride(l) - 1};
}
constexpr bool contains(const Lattice& l, Int3 p) {
  return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < l.size.x && p.y < l.size.y && p.z < l.size.z;
}
/// Index of the node in the whole body.
constexpr Int3 in_body(const Lattice& l, Int3 p) { return {p.x, p.y, p.z + l.first}; }
constexpr Vec3 rest_position(const Lattice& l, Int3 p) {
  return {float(p.x) * l.spacing.x, float(p.y) * l.spacing.y, float(p.z + l.first) * l.spacing.z};
}

/// Distance in slots from a node with i of the given parity (0 even, 1 odd) to its neighbor at `offset`
/// (components -1, 0, 1).
constexpr int slot_offset(const Lattice& l, Int3 offset, int parity) {
  const int rows = offset.z * layer_stride(l) + offset.y * row_stride(l);
  if (offset.x == 0) return rows;
  if (parity == 0) return rows + l.half + (offset.x > 0 ? 0 : -1);
  return rows - l.half + (offset.x > 0 ? 1 : 0);
}
/// Family of the edge with this offset from its lower end.
constexpr int family_of(Int3 offset) {
  constexpr unsigned kFamilyOf = 0x65423100;  // by x + 2 y + 4 z; kFamilies is not available on a GPU
  if (offset == Int3{0, 0, 0} || ((offset.x | offset.y | offset.z) & ~1) != 0) return -1;
  return int(kFamilyOf >> 4 * corner_of(offset) & 15);
}
/// Number of nodes in the even (0) or odd (1) half of a row.
constexpr int half_count(const Lattice& l, int parity) { return (l.size.x + 1 - parity) / 2; }

}  // namespace turgor
