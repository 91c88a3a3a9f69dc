#include "turgor/models/lattice/cutting/virtual_nodes.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/element_fragments.hpp"

namespace turgor::lattice {

namespace {

/// Two fragments that share area of a face; indices in FragmentsAroundNode::group.
struct Connection {
  int a = 0, b = 0;
  bool operator==(const Connection&) const = default;
};

/// Fragments in the eight cells around one node, in groups of connected fragments.
struct FragmentsAroundNode {
  const Model& model;
  Fragments& fragments;
  Int3 node;
  const CutCell* cell[8] = {};  // the node is corner c of cell[c]; null if that cell is not near a cut
  int first[9] = {};            // index in `group` of each cell's first fragment
  std::vector<int> group;       // union-find parent, per fragment
  std::vector<Connection> connections;

  FragmentsAroundNode(const Model& m, Fragments& p, Int3 n) : model(m), fragments(p), node(n) {
    for (int c = 0; c < 8; c++) {
      const Int3 corner = node - cell_corner(c), last = p.fine.cells.size - Int3{2, 2, 2};
      const bool inside = corner == min(max(corner, Int3{0, 0, 0}), last);
      cell[c] = inside ? find_cell(p, node_slot(p.fine.cells, corner)) : nullptr;
      first[c + 1] = first[c] + (cell[c] ? cell[c]->fragment_count : 0);
    }
  }

  /// Copies the groups from earlier fragments if no cell around the node has changed since.
  bool copy_groups(const EarlierFragments& earlier) {
    if (!earlier.fragments) return false;
    for (int c = 0; c < 8; c++)
      if (cell[c] && earlier.index(fragments, *cell[c]) < 0) return false;
    const NodeGroups& known = earlier.fragments->stages.groups;
    const int slot = node_slot(fragments.fine.cells, node);
    const auto at = std::lower_bound(known.slot.begin(), known.slot.end(), slot);
    if (at == known.slot.end() || *at != slot) return false;
    const auto n = std::size_t(at - known.slot.begin());
    group.assign(known.root.begin() + known.begin[n], known.root.begin() + known.begin[n + 1]);
    TURGOR_CHECK(group.size() == std::size_t(first[8]), "groups are those of the fragments around a node");
    return true;
  }
  /// Connects fragments across common faces; thin fragments also across common edges and corners.
  void connect() {
    group.resize(std::size_t(first[8]));
    std::iota(group.begin(), group.end(), 0);
    for (int a = 0; a < 8; a++)
      for (int b = a + 1; b < 8; b++)
        if (cell[a] && cell[b]) {
          if (std::popcount(unsigned(a ^ b)) == 1) join_faces(a, b);
          if (has_thin(a) || has_thin(b)) join_thin(a, b);
        }
    join_connected();
  }
  void add_connection(int a, int b) {
    if (connections.empty() || connections.back() != Connection{a, b}) connections.push_back({a, b});
  }

  /// Joins connected fragments, except where a blade ends: a fragment that contains the node is connected to
  /// one on the other side of the blade. That one gets a virtual node if it has a node of its cell, and if
  /// its group fills a tenth of a cell or more. Tension would carry away a virtual node with less tissue.
  void join_connected() {
    constexpr double kLeastSupport = 0.1;  // [cells]; without it virtual nodes moved 5 times as far as lips
    // ends of blades are opened if cut cells are elements
    const bool opens = has_cut_elements(model);
    const std::vector<std::uint8_t> at_node = opens ? fragments_at_node() : std::vector<std::uint8_t>{};
    std::vector<Connection> ends;
    for (const Connection& c : connections) {
      const bool is_end = opens && at_node[std::size_t(c.a)] != at_node[std::size_t(c.b)];
      if (is_end && has_node_of_cell(at_node[std::size_t(c.a)] ? c.b : c.a))
        ends.push_back(c);
      else
        join_sets(group, c.a, c.b);
    }
    if (ends.empty()) return;
    // tissue of each group
    std::vector<double> support(group.size());
    for (int n = 0; n < first[8]; n++) support[std::size_t(root_of(group, n))] += volume(n);
    std::erase_if(ends, [&](const Connection& c) {
      return std::min(support[std::size_t(root_of(group, c.a))], support[std::size_t(root_of(group, c.b))]) >=
             kLeastSupport;
    });
    for (const Connection& c : ends) join_sets(group, c.a, c.b);
  }
  /// Marks the fragments that contain the node. Where a blade ends exactly at the node, it separates a thin
  /// fragment with the node from the rest of a cell beside it. The cell behind the end holds this rest, which
  /// counts as containing the node.
  std::vector<std::uint8_t> fragments_at_node() const {
    const Int3 at = first_of_cell(fragments.fine, node);
    std::vector<std::uint8_t> contains(group.size());
    for (int c = 0; c < 8; c++)
      if (cell[c])
        if (const int own = label(c, at); own >= 0) contains[std::size_t(first[c] + own)] = 1;
    std::vector<std::uint8_t> counts = contains;
    const auto add_rest = [&](int whole, int rest) {
      if (!contains[std::size_t(whole)] || contains[std::size_t(rest)] || is_thin(whole)) return;
      const int c = cell_of(rest), own = label(c, at);
      if (own >= 0 && is_thin(c, own)) counts[std::size_t(rest)] = 1;
    };
    for (const Connection& c : connections) add_rest(c.a, c.b), add_rest(c.b, c.a);
    return counts;
  }
  /// Cell of a fragment, from 0 to 7.
  int cell_of(int n) const { return int(std::upper_bound(first, first + 9, n) - first) - 1; }
  bool is_thin(int n) const { return is_thin(cell_of(n), n - first[cell_of(n)]); }
  /// True if a fragment contains one of the eight nodes of its cell.
  bool has_node_of_cell(int n) const {
    const int c = cell_of(n);
    for (int corner = 0; corner < 8; corner++) {
      const Int3 p = hadamard(node - cell_corner(c) + cell_corner(corner), fragments.fine.subdivisions);
      if (label(c, p) == n - first[c]) return true;
    }
    return false;
  }
  /// Fraction of a cell that a fragment fills; 0 in cells that are no elements.
  double volume(int n) const {
    const FineLattice& f = fragments.fine;
    const int c = cell_of(n);
    if (!(model.anatomy.cell_young[std::size_t(cell[c]->slot)] > 0)) return 0;
    double sum = 0;
    for_sub_nodes(f, [&](Int3 p) {
      if (fragments.label[cell[c]->first_sub_index + std::size_t(sub_index(f, p))] != n - first[c]) return;
      double weight = 1;
      for (int axis = 0; axis < 3; axis++)
        if (p[axis] == 0 || p[axis] == f.subdivisions[axis]) weight *= 0.5;
      sum += weight;
    });
    return sum / (f.subdivisions.x * f.subdivisions.y * f.subdivisions.z);
  }

  bool has_thin(int c) const {
    for (int p = 0; p < cell[c]->fragment_count; p++)
      if (is_thin(c, p)) return true;
    return false;
  }
  int label(int c, Int3 p) const {
    TURGOR_CHECK(cell[c] != nullptr, "labels are read in cut cells");
    const FineLattice& f = fragments.fine;
    const Int3 local = p - first_of_cell(f, node - cell_corner(c));
    return fragments.label[cell[c]->first_sub_index + std::size_t(sub_index(f, local))];
  }
  bool is_thin(int c, int fragment) const {
    return fragments.all[std::size_t(cell[c]->first_fragment + fragment)].thin;
  }
  /// Connects fragments of two cells that share area in the common face. They share area if three corners of
  /// a square of fine nodes belong to both. Fewer corners suffice if a cut edge separates one of them from
  /// another corner of the square. Fragments that touch only along a cell edge where a blade ends stay
  /// separate.
  void join_faces(int a, int b) {
    const Int3 low = shared_sub_nodes(a, b).first;
    // axes of the common face
    Int3 side[2];
    int sides = 0;
    for (int axis = 0; axis < 3; axis++)
      if ((a >> axis & 1) == (b >> axis & 1)) side[sides++] = kFamilies[std::size_t(axis)];
    TURGOR_CHECK(sides == 2, "cells that share a face differ along one axis");
    for (int j = 0; j < dot(side[1], fragments.fine.subdivisions); j++)
      for (int i = 0; i < dot(side[0], fragments.fine.subdivisions); i++) {
        const Int3 p = low + side[0] * i + side[1] * j;
        join_square(a, b, {p, p + side[0], p + side[1], p + side[0] + side[1]});
      }
  }
  void join_square(int a, int b, const std::array<Int3, 4>& corners) {
    int in_a[4], in_b[4];
    for (std::size_t c = 0; c < 4; c++) in_a[c] = label(a, corners[c]), in_b[c] = label(b, corners[c]);
    for (std::size_t c = 0; c < 4; c++) {
      if (in_a[c] < 0 || in_b[c] < 0) continue;
      int alike = 0;
      bool cut = false;  // cut edge to another corner of the square: the tissue reaches the blade
      for (std::size_t d = 0; d < 4; d++) {
        const bool same = in_a[d] == in_a[c] && in_b[d] == in_b[c];
        alike += same;
        cut = cut || (!same && is_cut(a, corners[c], corners[d]));
      }
      if (alike >= 3 || cut) add_connection(first[a] + in_a[c], first[b] + in_b[c]);
    }
  }
  /// True if the edge between two fine nodes of a cell is cut; false if no edge connects them.
  bool is_cut(int c, Int3 p, Int3 q) const {
    const bool up = family_of(q - p) >= 0;
    const int family = up ? family_of(q - p) : family_of(p - q);
    if (family < 0) return false;
    const FineLattice& f = fragments.fine;
    const Int3 local = (up ? p : q) - first_of_cell(f, node - cell_corner(c));
    return fragments.cut_bits[cell[c]->first_sub_index + std::size_t(sub_index(f, local))] >> family & 1;
  }
  /// Connects a thin fragment to the fragments of another cell with which it shares a fine node.
  void join_thin(int a, int b) {
    const auto [low, high] = shared_sub_nodes(a, b);
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (const int la = label(a, {i, j, k}), lb = label(b, {i, j, k}); la >= 0 && lb >= 0)
            if (is_thin(a, la) || is_thin(b, lb)) add_connection(first[a] + la, first[b] + lb);
  }
  /// Lowest and highest fine node that two cells share.
  std::pair<Int3, Int3> shared_sub_nodes(int a, int b) const {
    const Int3 at = first_of_cell(fragments.fine, node);
    Int3 low = at, high = at;
    for (int axis = 0; axis < 3; axis++) {
      if ((a >> axis & 1) != (b >> axis & 1)) continue;
      (a >> axis & 1 ? low : high)[axis] +=
          a >> axis & 1 ? -fragments.fine.subdivisions[axis] : fragments.fine.subdivisions[axis];
    }
    return {low, high};
  }
  /// Group that contains the node itself; -1 if the node is air.
  int own_group() {
    for (int c = 0; c < 8; c++)
      if (cell[c])
        if (const int l = label(c, first_of_cell(fragments.fine, node)); l >= 0)
          return root_of(group, first[c] + l);
    return -1;
  }
};

/// Creates a virtual node for each group of fragments around a node, except the group that contains the node.
/// Around an air node, every group gets one.
void add_virtual_nodes(const Model& model, const EarlierFragments& earlier, Fragments& out, Int3 node) {
  FragmentsAroundNode around(model, out, node);
  if (!around.copy_groups(earlier)) around.connect();
  // keep the groups
  NodeGroups& groups = out.stages.groups;
  groups.slot.push_back(node_slot(out.fine.cells, node));
  for (int n = 0; n < around.first[8]; n++) groups.root.push_back(std::int16_t(root_of(around.group, n)));
  groups.begin.push_back(int(groups.root.size()));
  // virtual nodes
  const int own = around.own_group();
  std::vector<int> virtual_node_of(std::size_t(around.first[8]), -1);
  for (int c = 0; c < 8; c++)
    for (int n = around.first[c]; n < around.first[c + 1]; n++) {
      const int group = root_of(around.group, n);
      if (group == own) continue;
      // the first fragment of a group creates the virtual node
      int& virtual_node = virtual_node_of[std::size_t(group)];
      if (virtual_node < 0) {
        virtual_node = slot_count(out.fine.cells) + int(out.virtual_nodes.size());
        out.virtual_nodes.push_back({.slot = node_slot(out.fine.cells, node),
                                     .lowest_node = std::numeric_limits<std::uint64_t>::max()});
      }
      // the fragment refers to it
      Fragment& fragment = out.all[std::size_t(around.cell[c]->first_fragment + n - around.first[c])];
      fragment.corner[std::size_t(c)] = virtual_node;
      VirtualNode& made = out.virtual_nodes[std::size_t(virtual_node - slot_count(out.fine.cells))];
      made.lowest_node = std::min(made.lowest_node, fragment.lowest_node);
    }
}

}  // namespace

void make_virtual_nodes(const Model& model, const EarlierFragments& earlier, Fragments& out) {
  std::vector<int> nodes;  // slots of the nodes of cut cells
  for (const CutCell& cell : out.cells) {
    if (!cell.is_cut) continue;
    const int parity = slot_node(out.fine.cells, cell.slot).x & 1;
    for (int c = 0; c < 8; c++)
      nodes.push_back(cell.slot + slot_offset(out.fine.cells, cell_corner(c), parity));
  }
  sort_unique(nodes);
  for (const int slot : nodes) add_virtual_nodes(model, earlier, out, slot_node(out.fine.cells, slot));
}

}  // namespace turgor::lattice
