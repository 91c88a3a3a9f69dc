// Point and corner queries on the fragments of a cut body: fragment that contains a point, and displacement
// of a corner. Plain pointers, for host and device.
#pragma once

#include "turgor/geometry/kuhn_raster.hpp"
#include "turgor/models/lattice/cutting/extrapolate.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

/// Fragments and cut edges in host or device memory.
struct FragmentView {
  FineLattice fine;
  const CutCell* cells;
  const Fragment* all;
  const VirtualNode* virtual_nodes;
  const FitTerm* fit_terms;
  const GhostFragment* ghosts;
  int first_ghost_position;  // position index of the first ghost corner; positions are ordered: slots,
                             // virtual nodes, ghost corners
  const std::int16_t* label;
  KeyTable edge_index;
  const CutEdge* edges;                   // Cuts::edges
  const VirtualNodeDisplacement* shifts;  // Motion::virtual_u; null if no virtual node is solved for
};

/// `virtual_u` is Motion::virtual_u. It is ignored if its size is not the number of virtual nodes.
inline FragmentView view(const Fragments& fragments, const Cuts& cuts,
                         std::span<const VirtualNodeDisplacement> virtual_u = {}) {
  const bool solved = virtual_u.size() == fragments.virtual_nodes.size();
  return {.fine = fragments.fine,
          .cells = fragments.cells.data(),
          .all = fragments.all.data(),
          .virtual_nodes = fragments.virtual_nodes.data(),
          .fit_terms = fragments.fit_terms.data(),
          .ghosts = fragments.ghosts.data(),
          .first_ghost_position = slot_count(fragments.fine.cells) + int(fragments.virtual_nodes.size()),
          .label = fragments.label.data(),
          .edge_index = fragments.edge_index.table(),
          .edges = cuts.edges.data(),
          .shifts = solved ? virtual_u.data() : nullptr};
}

TURGOR_HD inline Crossing crossing(const FragmentView& fragments, Int3 a, Int3 b) {
  const Int3 offset = b - a;
  const bool swapped = offset.x < 0 || offset.y < 0 || offset.z < 0;
  const Int3 lower = swapped ? b : a;
  const int index =
      fragments.edge_index.find(fine_edge_key(fragments.fine, lower, family_of(swapped ? -offset : offset)));
  if (index < 0) return {};
  const CutEdge& edge = fragments.edges[index];
  return {.edge = &edge,
          .fraction = swapped ? 1 - edge.fraction : edge.fraction,
          .rightward = (edge.rightward != 0) != swapped};
}

/// Level set at the corners of a tetrahedron with two fragment labels. It is positive at corners with the
/// first corner's label. With level 1 at the first corner, it is linear along cut edges and zero where they
/// are cut.
TURGOR_HD inline std::array<Real, 4> two_fragment_level_set(const FragmentView& fragments,
                                                            const std::array<Int3, 4>& nodes,
                                                            const std::array<int, 4>& label) {
  std::array<Real, 4> level{};
  std::array<int, 4> count{};
  const auto cut = [&](std::size_t a, std::size_t b) {
    const Crossing found = crossing(fragments, nodes[a], nodes[b]);
    const Real least = Real(0.01), most = Real(0.99);
    if (!found.edge) return Real(0.5);  // edge not cut: the blade ends in the tetrahedron
    return found.fraction < least ? least : found.fraction > most ? most : found.fraction;
  };
  level[0] = 1;
  for (std::size_t b = 1; b < 4; b++)  // other label: from the first corner's level
    if (label[b] != label[0]) level[b] = 1 - 1 / cut(0, b);
  // same label: mean over the edges to corners of the other label
  for (std::size_t a = 1; a < 4; a++) {
    if (label[a] != label[0]) continue;
    for (std::size_t b = 1; b < 4; b++)
      if (label[b] != label[0]) level[a] -= level[b] * cut(a, b) / (1 - cut(a, b)), count[a]++;
    level[a] /= Real(count[a] > 1 ? count[a] : 1);
  }
  return level;
}

/// Index in its cell of the fragment that contains a point. Ghosts are numbered after the cell's own
/// fragments; -1 if the cell has neither. `at` is in cell coordinates, 0 to 1.
TURGOR_HD inline int fragment_at(const FragmentView& fragments, const CutCell& cell, Vec3 at) {
  if (cell.fragment_count + cell.ghost_count < 2) return cell.fragment_count - 1;
  const FineLattice& f = fragments.fine;
  // sub-cell and coordinates in it
  Vec3 in_sub_cell;
  Int3 sub_cell;
  for (int axis = 0; axis < 3; axis++) {
    const Real x = at[axis] * Real(f.subdivisions[axis]);
    const int most = f.subdivisions[axis] - 1, floor = int(std::floor(x));
    sub_cell[axis] = floor < 0 ? 0 : floor > most ? most : floor;
    const Real beyond = x - Real(sub_cell[axis]);
    in_sub_cell[axis] = beyond < 0 ? Real(0) : beyond > 1 ? Real(1) : beyond;
  }
  // labels at the corners of the Kuhn tetrahedron that contains the point
  const int tet = kuhn_tet_at(in_sub_cell);
  const std::array<Int3, 4> corners = kuhn_corners(sub_cell, tet);
  const std::array<Real, 4> weight = path_weights(tet, in_sub_cell);
  std::array<int, 4> label{};
  bool two = true;
  int other = -1;
  for (std::size_t n = 0; n < 4; n++) {
    label[n] = fragment_of(fragments.label, cell, sub_index(f, corners[n]));
    if (label[n] == label[0]) continue;
    two &= other < 0 || label[n] == other;
    other = label[n];
  }
  // one label
  if (other < 0) return label[0];
  // three or more labels: the corner with the largest weight
  if (!two) {
    std::size_t most = 0;
    for (std::size_t n = 1; n < 4; n++)
      if (weight[most] < weight[n]) most = n;
    return label[most];
  }
  // two labels: sign of the level set
  std::array<Int3, 4> nodes;
  for (std::size_t n = 0; n < 4; n++) nodes[n] = first_of_cell(f, slot_node(f.cells, cell.slot)) + corners[n];
  const std::array<Real, 4> level = two_fragment_level_set(fragments, nodes, label);
  Real sum = 0;
  for (std::size_t n = 0; n < 4; n++) sum += level[n] * weight[n];
  return sum >= 0 ? label[0] : other;
}

/// True if a lattice edge between two corners of this cell is cut. `cut` is Cuts::cut.
TURGOR_HD inline bool has_cut_edge(const std::uint8_t* cut, const Lattice& lattice, int slot) {
  const int parity = slot_node(lattice, slot).x & 1;
  int found = 0;
  for (int n = 0; n < kCellCorners; n++)
    found |= cut[slot + slot_offset(lattice, cell_corner(n), parity)] & edges_from(n);
  return found != 0;
}

/// True if a blade separates two neighboring nodes. `offset` points from `near` to `far`. Neighbors without a
/// common edge are separated if any edge of the cell between them is cut.
TURGOR_HD inline bool is_separated(const std::uint8_t* cut, const Lattice& l, int near, int far,
                                   Int3 offset) {
  const bool up = family_of(offset) >= 0;
  if (const int family = up ? family_of(offset) : family_of(-offset); family >= 0)
    return cut[up ? near : far] >> family & 1;
  return has_cut_edge(cut, l, node_slot(l, slot_node(l, near) + min(offset, Int3{0, 0, 0})));
}

/// Displacement of a fragment corner [m]: a node, a virtual node, or an air node, which is extrapolated from
/// tissue. `body` is as in extrapolate_from_neighbors. The recursion is finite: fit terms refer to tissue
/// nodes or to virtual nodes with unknowns, whose own terms refer to nodes.
template <int kDepth = 3, class Body>
TURGOR_HD Vec3 corner_displacement(const Body& body, const FragmentView& fragments, int corner) {
  const Lattice& l = fragments.fine.cells;
  const int slots = slot_count(l);
  const VirtualNode* virtual_node = corner < slots ? nullptr : &fragments.virtual_nodes[corner - slots];
  // virtual node with a displacement of its own
  if (virtual_node != nullptr && virtual_node->has_unknowns && fragments.shifts != nullptr) {
    const VirtualNodeDisplacement& u = fragments.shifts[corner - slots];
    return {u.x, u.y, u.z};
  }
  // node, also for a small component without a fit: tissue, or air that is extrapolated from tissue
  if (virtual_node == nullptr || virtual_node->term_count == 0) {
    const int slot = virtual_node ? virtual_node->slot : corner;
    return body.is_solid(slot) ? body.u(slot) : extrapolate_from_neighbors(l, body, slot);
  }
  // linear combination of its fit terms
  Vec3 sum;
  if constexpr (kDepth > 0)
    for (int s = virtual_node->first_term; s < virtual_node->first_term + virtual_node->term_count; s++)
      sum += corner_displacement<kDepth - 1>(body, fragments, fragments.fit_terms[s].corner) *
             fragments.fit_terms[s].weight;
  return sum;
}

/// Displacement of a corner of the cell that contains a ghost, extrapolated from the owner cell.
template <class Body>
TURGOR_HD Vec3 ghost_displacement(const Body& body, const FragmentView& fragments, int ghost, int corner) {
  const Lattice& l = fragments.fine.cells;
  const GhostFragment& g = fragments.ghosts[ghost];
  const CutCell& home = fragments.cells[g.cell];
  const Int3 at = slot_node(l, g.slot) - slot_node(l, home.slot) + cell_corner(corner);
  const std::array<Real, 8> weight = trilinear(Vec3(at));
  Vec3 sum;
  for (std::size_t c = 0; c < 8; c++)
    if (weight[c] != 0)
      sum += corner_displacement(body, fragments, fragments.all[home.first_fragment + g.fragment].corner[c]) *
             weight[c];
  return sum;
}

/// Position indices of the corners of a fragment. Ghosts are numbered after the cell's own fragments.
TURGOR_HD inline std::array<int, 8> position_indices(const FragmentView& fragments, const CutCell& cell,
                                                     int fragment) {
  if (fragment < cell.fragment_count) return fragments.all[cell.first_fragment + fragment].corner;
  const int ghost = cell.first_ghost + fragment - cell.fragment_count;
  std::array<int, 8> corners{};
  for (int c = 0; c < 8; c++) corners[std::size_t(c)] = fragments.first_ghost_position + 8 * ghost + c;
  return corners;
}

/// True if one of a cell's own fragments or ghosts left the body.
TURGOR_HD inline bool is_excised(const FragmentView& fragments, const CutCell& cell, int fragment) {
  if (fragment < cell.fragment_count) return fragments.all[cell.first_fragment + fragment].excised;
  const GhostFragment& ghost = fragments.ghosts[cell.first_ghost + fragment - cell.fragment_count];
  return fragments.all[fragments.cells[ghost.cell].first_fragment + ghost.fragment].excised;
}

/// Slots of a cell's corners.
TURGOR_HD inline std::array<int, 8> cell_slots(const Lattice& l, int slot, int parity) {
  std::array<int, 8> slots{};
  for (int c = 0; c < 8; c++) slots[std::size_t(c)] = slot + slot_offset(l, cell_corner(c), parity);
  return slots;
}

/// Predicate for rest positions: true in one fragment or ghost, except in removed tissue.
struct FragmentFilter {
  const FragmentView& fragments;
  const std::uint8_t* removed;  // Cuts::removed; null if no node is removed or excised
  const CutCell* cut;           // null: the cell has a single fragment
  int fragment;
  Vec3d first, size;  // of the cell, rest frame
  const std::array<int, 8>& slots;

  TURGOR_HD bool operator()(Vec3 at) const {
    const Vec3d d = Vec3d(at) - first;
    const Vec3 in_cell(Vec3d{d.x / size.x, d.y / size.y, d.z / size.z});
    if (cut && fragment_at(fragments, *cut, in_cell) != fragment) return false;
    return removed == nullptr || !is_removed_tissue(in_cell);
  }

 private:
  /// True if removed nodes have more than half of the interpolation weight at a point. Near a cut, excised
  /// nodes count as tissue, because their fragments are excised one by one.
  TURGOR_HD bool is_removed_tissue(Vec3 at) const {
    const int tet = kuhn_tet_at(at);
    const std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, tet);
    const std::array<float, 4> weight = path_weights(tet, at);
    float removed_weight = 0;
    for (std::size_t n = 0; n < 4; n++)
      if (const std::uint8_t r = removed[slots[std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z)]];
          r == kRemoved || (r == kExcised && cut == nullptr))
        removed_weight += weight[n];
    return removed_weight > 0.5f;
  }
};

}  // namespace turgor::lattice
