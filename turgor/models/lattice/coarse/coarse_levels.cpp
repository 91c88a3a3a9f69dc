// Cells joined to blocks of two a side, and these again, as far as tissue in them holds together.
#include "turgor/models/lattice/coarse/coarse_levels.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

Int3 halved(Int3 a) { return {a.x / 2, a.y / 2, a.z / 2}; }

/// The corners of a block of two steps a side that a place in it is a mean of.
bool is_of_corner(Int3 place, int corner) {
  const Int3 c = cell_corner(corner);
  for (int axis = 0; axis < 3; axis++)
    if (place[axis] != 1 && place[axis] != 2 * c[axis]) return false;
  return true;
}

/// Which grains lie in one block, and the sets of nodes that these join.
struct BlockAggregates {
  const CoarseLevel& fine;
  std::vector<int> stamp, local;  // by node of the finer level
  std::vector<int> nodes;         // of the block
  std::vector<int> sets;          // of them (disjoint_sets.hpp)

  explicit BlockAggregates(const CoarseLevel& level)
      : fine(level), stamp(level.place.size(), -1), local(stamp) {}

  void gather(std::span<const int> aggregates, int block) {
    nodes.clear(), sets.clear();
    for (const int g : aggregates) {
      const Aggregate& grain = fine.aggregates[std::size_t(g)];
      for (const int n : grain.corner) {
        if (stamp[std::size_t(n)] != block) {
          stamp[std::size_t(n)] = block, local[std::size_t(n)] = int(nodes.size());
          sets.push_back(int(nodes.size())), nodes.push_back(n);
        }
        join_sets(sets, local[std::size_t(n)], local[std::size_t(grain.corner[0])]);
      }
    }
  }
};

/// Grains of the coarse level, with corners that are still their own; and which each node lies in.
std::vector<std::pair<int, int>> join_grains(CoarseLevel& fine, CoarseLevel& coarse) {
  std::vector<int> order(fine.aggregates.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int g) {
    const Int3 b = halved(fine.aggregates[std::size_t(g)].low);
    return std::tuple(b.z, b.y, b.x);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  BlockAggregates block(fine);
  std::vector<std::pair<int, int>> lies_in;  // node, grain
  std::vector<int> grain_of_root, aggregate_of;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && key(order[end]) == key(order[begin])) end++;
    block.gather(std::span(order).subspan(begin, end - begin), int(begin));
    grain_of_root.assign(block.nodes.size(), -1), aggregate_of.clear();
    for (std::size_t n = 0; n < block.nodes.size(); n++) {
      int& grain = grain_of_root[std::size_t(root_of(block.sets, int(n)))];
      if (grain < 0) {
        grain = int(coarse.aggregates.size());
        coarse.aggregates.push_back({.low = halved(fine.aggregates[std::size_t(order[begin])].low)});
      }
      aggregate_of.push_back(grain);
      lies_in.push_back({block.nodes[n], grain});
    }
    for (std::size_t g = begin; g < end; g++) {
      Aggregate& grain = fine.aggregates[std::size_t(order[g])];
      grain.parent = aggregate_of[std::size_t(block.local[std::size_t(grain.corner[0])])];
      if (grain.is_parted) coarse.aggregates[std::size_t(grain.parent)].is_parted = true;
    }
  }
  std::sort(lies_in.begin(), lies_in.end());
  return lies_in;
}

/// Corners of neighbouring grains are one where they share a node that is a mean of them.
void join_corners(const CoarseLevel& fine, std::span<const std::pair<int, int>> lies_in,
                  CoarseLevel& coarse) {
  std::vector<int> corners(8 * coarse.aggregates.size());
  std::iota(corners.begin(), corners.end(), 0);
  for (std::size_t n = 1; n < lies_in.size(); n++) {
    if (lies_in[n].first != lies_in[n - 1].first) continue;
    const int a = lies_in[n - 1].second, b = lies_in[n].second;
    const Int3 at = fine.place[std::size_t(lies_in[n].first)];
    const Int3 low_a = coarse.aggregates[std::size_t(a)].low, low_b = coarse.aggregates[std::size_t(b)].low;
    for (int p = 0; p < 8; p++)
      for (int q = 0; q < 8; q++)
        if (is_of_corner(at - low_a * 2, p) && low_a + cell_corner(p) == low_b + cell_corner(q))
          join_sets(corners, 8 * a + p, 8 * b + q);
  }
  std::vector<int> number(8 * coarse.aggregates.size(), -1);
  for (std::size_t c = 0; c < number.size(); c++) {
    const auto root = std::size_t(root_of(corners, int(c)));
    if (number[root] < 0) {
      number[root] = int(coarse.place.size());
      coarse.place.push_back(coarse.aggregates[root / 8].low + cell_corner(int(root % 8)));
    }
    coarse.aggregates[c / 8].corner[c % 8] = number[root];
  }
}

}  // namespace

CoarseLevel coarsen(CoarseLevel& fine) {
  CoarseLevel coarse;
  const std::vector<std::pair<int, int>> lies_in = join_grains(fine, coarse);
  join_corners(fine, lies_in, coarse);
  fine.lies_begin.assign(fine.place.size() + 1, 0);
  for (const auto& [node, grain] : lies_in) {
    fine.lies_begin[std::size_t(node) + 1]++;
    fine.lies_in.push_back(grain);
  }
  std::partial_sum(fine.lies_begin.begin(), fine.lies_begin.end(), fine.lies_begin.begin());
  return coarse;
}

FineCells find_cells(const Model& model, const State& state) {
  const Lattice& l = model.lattice;
  const int slots = slot_count(l);
  FineCells cells;
  cells.copy_slot.assign(state.virtual_nodes.size(), -1);
  for (const ElementNode& copy : state.parts.virtual_nodes)
    cells.copy_slot[std::size_t(copy.corner - slots)] = copy.slot;
  cells.level.place.resize(std::size_t(slots) + state.virtual_nodes.size());
  const auto add = [&](Int3 low, const std::array<int, 8>& corner, Real young) {
    for (std::size_t n = 0; n < 8; n++) cells.level.place[std::size_t(corner[n])] = low + cell_corner(int(n));
    cells.level.aggregates.push_back({.low = low, .corner = corner});
    cells.young.push_back(young);
  };
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int i = 0; i + 1 < l.size.x; i++)
        if (is_whole_now(model, state, {i, j, k})) {
          std::array<int, 8> corner{};
          for (int n = 0; n < 8; n++) corner[std::size_t(n)] = node_slot(l, Int3{i, j, k} + cell_corner(n));
          add({i, j, k}, corner, model.cell_young[std::size_t(corner[0])]);
        }
  for (const CutCellElement& part : state.parts.cells) {
    const int first = part.corner[0];
    add(slot_node(l, first < slots ? first : cells.copy_slot[std::size_t(first - slots)]), part.corner,
        part.young);
    cells.level.aggregates.back().is_parted = true;
  }
  return cells;
}

Leaf leaf_above(std::span<const CoarseLevel> levels, int level, int grain) {
  Leaf leaf;
  for (int g = grain; g >= 0; g = levels[std::size_t(level++)].aggregates[std::size_t(g)].parent) {
    if (levels[std::size_t(level)].aggregates[std::size_t(g)].is_parted) break;
    leaf = {level, g};
  }
  return leaf;
}

}  // namespace turgor::lattice
