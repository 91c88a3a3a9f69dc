// Aggregation of cells to blocks of two per side, level by level, as far as tissue is connected.
#include "turgor/models/lattice/coarse/coarse_levels.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

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

/// Creates the aggregates of the coarse level, without corners yet. Returns the pairs of node and aggregate
/// that contains it.
std::vector<std::pair<int, int>> merge_aggregates(CoarseLevel& fine, CoarseLevel& coarse) {
  // aggregates by block
  std::vector<int> order(fine.aggregates.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int g) {
    const Int3 b = halved(fine.aggregates[std::size_t(g)].low);
    return std::tuple(b.z, b.y, b.x);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
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
  std::sort(memberships.begin(), memberships.end());
  return memberships;
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
    for (int p = 0; p < 8; p++)
      for (int q = 0; q < 8; q++)
        if (is_interpolated_from(at - low_a * 2, p) && low_a + cell_corner(p) == low_b + cell_corner(q))
          join_sets(corners, 8 * a + p, 8 * b + q);
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
  // whole cells
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int i = 0; i + 1 < l.size.x; i++)
        if (is_whole_cell(model, state.cuts, {i, j, k})) {
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
