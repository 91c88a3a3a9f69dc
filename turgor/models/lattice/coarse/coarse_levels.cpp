// Aggregation of cells to blocks of two per side, level by level, as far as tissue is connected.
#include "turgor/models/lattice/coarse/coarse_levels.hpp"

#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

Int3 halved(Int3 a) { return {a.x / 2, a.y / 2, a.z / 2}; }

/// True if a position in a block of two spacings per side is interpolated from this corner.
bool is_interpolated_from(Int3 position, int corner) {
  const Int3 c = cell_corner(corner);
  for (int axis = 0; axis < 3; axis++)
    if (position[axis] != 1 && position[axis] != 2 * c[axis]) return false;
  return true;
}

/// Aggregates in one block, and the connected sets of their nodes.
struct BlockAggregates {
  const CoarseLevel& fine;
  std::vector<int> stamp, local;  // by node of the finer level
  std::vector<int> nodes;         // of the block
  std::vector<int> sets;          // over `nodes` (disjoint_sets.hpp)

  explicit BlockAggregates(const CoarseLevel& level)
      : fine(level), stamp(level.position.size(), -1), local(stamp) {}

  void gather(std::span<const int> aggregates, int block) {
    nodes.clear(), sets.clear();
    for (const int g : aggregates) {
      const Aggregate& aggregate = fine.aggregates[std::size_t(g)];
      for (const int n : aggregate.corner) {
        if (stamp[std::size_t(n)] != block) {
          stamp[std::size_t(n)] = block, local[std::size_t(n)] = int(nodes.size());
          sets.push_back(int(nodes.size())), nodes.push_back(n);
        }
        join_sets(sets, local[std::size_t(n)], local[std::size_t(aggregate.corner[0])]);
      }
    }
  }
};

/// Number of the block of every aggregate, x fastest.
std::vector<int> block_keys(const CoarseLevel& fine) {
  Int3 size{1, 1, 1};
  for (const Aggregate& aggregate : fine.aggregates) size = max(size, halved(aggregate.low) + Int3{1, 1, 1});
  std::vector<int> keys;
  keys.reserve(fine.aggregates.size());
  for (const Aggregate& aggregate : fine.aggregates) {
    const Int3 b = halved(aggregate.low);
    keys.push_back((b.z * size.y + b.y) * size.x + b.x);
  }
  return keys;
}

/// Indices by ascending key, and equal keys by ascending index: a counting sort.
std::vector<int> order_by(std::span<const int> keys) {
  const int most = keys.empty() ? 0 : *std::max_element(keys.begin(), keys.end());
  std::vector<int> begin(std::size_t(most) + 2, 0), order(keys.size());
  for (const int key : keys) begin[std::size_t(key) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (std::size_t n = 0; n < keys.size(); n++) order[std::size_t(begin[std::size_t(keys[n])]++)] = int(n);
  return order;
}

/// Creates the aggregates of the coarse level, without corners yet. Returns the pairs of node and aggregate
/// that contains it.
std::vector<std::pair<int, int>> merge_aggregates(CoarseLevel& fine, CoarseLevel& coarse) {
  // aggregates by block
  const std::vector<int> keys = block_keys(fine);
  const std::vector<int> order = order_by(keys);
  const auto key = [&](int g) { return keys[std::size_t(g)]; };
  BlockAggregates block(fine);
  std::vector<std::pair<int, int>> memberships;  // node, aggregate
  std::vector<int> aggregate_of_root, aggregate_of;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    // connected sets of one block
    while (end < order.size() && key(order[end]) == key(order[begin])) end++;
    block.gather(std::span(order).subspan(begin, end - begin), int(begin));
    // one coarse aggregate per set
    aggregate_of_root.assign(block.nodes.size(), -1), aggregate_of.clear();
    for (std::size_t n = 0; n < block.nodes.size(); n++) {
      int& aggregate = aggregate_of_root[std::size_t(root_of(block.sets, int(n)))];
      if (aggregate < 0) {
        aggregate = int(coarse.aggregates.size());
        coarse.aggregates.push_back({.low = halved(fine.aggregates[std::size_t(order[begin])].low)});
      }
      aggregate_of.push_back(aggregate);
      memberships.push_back({block.nodes[n], aggregate});
    }
    // parents
    for (std::size_t g = begin; g < end; g++) {
      Aggregate& aggregate = fine.aggregates[std::size_t(order[g])];
      aggregate.parent = aggregate_of[std::size_t(block.local[std::size_t(aggregate.corner[0])])];
      if (aggregate.is_cut) coarse.aggregates[std::size_t(aggregate.parent)].is_cut = true;
    }
  }
  // by node; aggregates ascend already
  std::vector<int> nodes;
  nodes.reserve(memberships.size());
  for (const auto& [node, aggregate] : memberships) nodes.push_back(node);
  std::vector<std::pair<int, int>> sorted;
  sorted.reserve(memberships.size());
  for (const int n : order_by(nodes)) sorted.push_back(memberships[std::size_t(n)]);
  return sorted;
}

/// Numbers the corners of the coarse aggregates. Corners of neighbor aggregates are the same if they share a
/// node that is interpolated from them.
void merge_corners(const CoarseLevel& fine, std::span<const std::pair<int, int>> memberships,
                   CoarseLevel& coarse) {
  TURGOR_CHECK(std::is_sorted(memberships.begin(), memberships.end()), "memberships ascend by node");
  // same corners
  std::vector<int> corners(8 * coarse.aggregates.size());
  std::iota(corners.begin(), corners.end(), 0);
  for (std::size_t n = 1; n < memberships.size(); n++) {
    if (memberships[n].first != memberships[n - 1].first) continue;
    const int a = memberships[n - 1].second, b = memberships[n].second;
    const Int3 at = fine.position[std::size_t(memberships[n].first)];
    const Int3 low_a = coarse.aggregates[std::size_t(a)].low, low_b = coarse.aggregates[std::size_t(b)].low;
    for (int p = 0; p < 8; p++) {
      if (!is_interpolated_from(at - low_a * 2, p)) continue;
      const Int3 other = low_a + cell_corner(p) - low_b;
      if (min(other, Int3{0, 0, 0}) == Int3{0, 0, 0} && max(other, Int3{1, 1, 1}) == Int3{1, 1, 1})
        join_sets(corners, 8 * a + p, 8 * b + other.x + 2 * other.y + 4 * other.z);
    }
  }
  // numbers
  std::vector<int> number(8 * coarse.aggregates.size(), -1);
  for (std::size_t c = 0; c < number.size(); c++) {
    const auto root = std::size_t(root_of(corners, int(c)));
    if (number[root] < 0) {
      number[root] = int(coarse.position.size());
      coarse.position.push_back(coarse.aggregates[root / 8].low + cell_corner(int(root % 8)));
    }
    coarse.aggregates[c / 8].corner[c % 8] = number[root];
  }
}

}  // namespace

CoarseLevel coarsen(CoarseLevel& fine) {
  CoarseLevel coarse;
  const std::vector<std::pair<int, int>> memberships = merge_aggregates(fine, coarse);
  merge_corners(fine, memberships, coarse);
  // aggregates by node
  fine.membership_begin.assign(fine.position.size() + 1, 0);
  for (const auto& [node, aggregate] : memberships) {
    fine.membership_begin[std::size_t(node) + 1]++;
    fine.memberships.push_back(aggregate);
  }
  std::partial_sum(fine.membership_begin.begin(), fine.membership_begin.end(), fine.membership_begin.begin());
  TURGOR_CHECK(is_csr(fine.membership_begin, fine.memberships.size()), "the nodes cover all memberships");
  return coarse;
}

FineCells find_fine_cells(const Model& model, const State& state) {
  const Lattice& l = model.anatomy.lattice;
  const int slots = slot_count(l);
  FineCells cells;
  // lattice nodes of virtual nodes
  cells.virtual_node_slot.assign(state.motion.virtual_u.size(), -1);
  for (const ElementNode& virtual_node : state.cut_elements.virtual_nodes)
    cells.virtual_node_slot[std::size_t(virtual_node.corner - slots)] = virtual_node.slot;
  cells.level.position.resize(std::size_t(slots) + state.motion.virtual_u.size());
  const auto add = [&](Int3 low, const std::array<int, 8>& corner, Real young) {
    for (std::size_t n = 0; n < 8; n++)
      cells.level.position[std::size_t(corner[n])] = low + cell_corner(int(n));
    cells.level.aggregates.push_back({.low = low, .corner = corner});
    cells.young.push_back(young);
  };
  // whole cells; only rows near cuts can have others
  const auto is_whole = [&](Int3 cell) {
    const auto slot = std::size_t(node_slot(l, cell));
    return model.anatomy.cell_young[slot] > 0 &&
           (!state.cuts.row_cut[slot / std::size_t(row_stride(l))] || is_whole_cell(model, state.cuts, cell));
  };
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int i = 0; i + 1 < l.size.x; i++)
        if (is_whole({i, j, k})) {
          std::array<int, 8> corner{};
          for (int n = 0; n < 8; n++) corner[std::size_t(n)] = node_slot(l, Int3{i, j, k} + cell_corner(n));
          add({i, j, k}, corner, model.anatomy.cell_young[std::size_t(corner[0])]);
        }
  // cut-cell elements
  for (const CutCellElement& element : state.cut_elements.cells) {
    const int first = element.corner[0];
    add(slot_node(l, first < slots ? first : cells.virtual_node_slot[std::size_t(first - slots)]),
        element.corner, element.young);
    cells.level.aggregates.back().is_cut = true;
  }
  TURGOR_CHECK(cells.young.size() == cells.level.aggregates.size(), "every cell has a modulus");
  return cells;
}

AggregateIndex leaf_above(std::span<const CoarseLevel> levels, int level, int aggregate) {
  AggregateIndex leaf;
  for (int g = aggregate; g >= 0; g = levels[std::size_t(level++)].aggregates[std::size_t(g)].parent) {
    if (levels[std::size_t(level)].aggregates[std::size_t(g)].is_cut) break;
    leaf = {level, g};
  }
  return leaf;
}

}  // namespace turgor::lattice
