// How nodes follow the unknowns of a coarse space.
#include <algorithm>

#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/prolongation.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Blocks have four steps a side, and are doubled until no more corners than this are left. What a few sweeps
/// do not carry over four steps is little; blocks of two cost four times as much and leave half as much.
constexpr std::size_t kLeastLevels = 3, kMostLevels = 6, kMostNodes = 1000;
/// Beside blades too: with more, what they went through is made of larger blocks.
constexpr std::size_t kMostUnknowns = 3000;
/// Bodies of so many pieces go without.
constexpr int kTooMany = 20000;

struct SpaceBuilder {
  const Model& model;
  const State& state;
  const FineCells& cells;
  std::span<const CoarseLevel> levels;
  CoarseSpace& space;
  std::vector<std::vector<int>> row_of, block_of;  // by level, of its nodes and its grains; −1 = not yet

  SpaceBuilder(const Model& m, const State& s, const FineCells& c, std::span<const CoarseLevel> all,
               CoarseSpace& out)
      : model(m), state(s), cells(c), levels(all), space(out) {
    space.row_begin = {0};
    for (const CoarseLevel& level : levels) {
      row_of.emplace_back(level.place.size(), -1);
      block_of.emplace_back(level.aggregates.size(), -1);
    }
  }

  int add_row(std::span<const CoarseTerm> terms) {
    space.terms.insert(space.terms.end(), terms.begin(), terms.end());
    space.row_begin.push_back(int(space.terms.size()));
    return int(space.row_begin.size()) - 2;
  }

  /// A grain of the next level in which a node lies and that no blade went through; −1: none, it is an
  /// unknown itself.
  int grain_above(std::size_t level, int node) const {
    const CoarseLevel& here = levels[level];
    if (level + 1 == levels.size()) return -1;
    for (int n = here.lies_begin[std::size_t(node)]; n < here.lies_begin[std::size_t(node) + 1]; n++)
      if (const int g = here.lies_in[std::size_t(n)]; !levels[level + 1].aggregates[std::size_t(g)].is_parted)
        return g;
    return -1;
  }

  /// What a node of a level is of the unknowns.
  int row(std::size_t level, int node) {
    int& known = row_of[level][std::size_t(node)];
    if (known >= 0) return known;
    const int above = grain_above(level, node);
    if (above < 0) {
      const CoarseTerm itself{space.unknowns++, 1};
      return known = add_row({&itself, 1});
    }
    const Aggregate& grain = levels[level + 1].aggregates[std::size_t(above)];
    const std::array<float, 8> weights =
        corner_weights({.low = grain.low * 2, .size = 2}, levels[level].place[std::size_t(node)]);
    std::vector<CoarseTerm> sum;
    for (std::size_t c = 0; c < 8; c++) {
      if (weights[c] == 0) continue;
      const auto of = std::size_t(row(level + 1, grain.corner[c]));
      for (int t = space.row_begin[of]; t < space.row_begin[of + 1]; t++) {
        const CoarseTerm term = space.terms[std::size_t(t)];
        const auto same = std::find_if(sum.begin(), sum.end(),
                                       [&](const CoarseTerm& s) { return s.unknown == term.unknown; });
        if (same == sum.end())
          sum.push_back({term.unknown, term.weight * weights[c]});
        else
          same->weight += term.weight * weights[c];
      }
    }
    return known = add_row(sum);
  }

  int block(Leaf leaf) {
    int& known = block_of[std::size_t(leaf.level)][std::size_t(leaf.grain)];
    if (known >= 0) return known;
    const Aggregate& grain = levels[std::size_t(leaf.level)].aggregates[std::size_t(leaf.grain)];
    CoarseBlock made{.low = grain.low * (1 << leaf.level), .size = 1 << leaf.level, .leaf = leaf};
    for (std::size_t c = 0; c < 8; c++) made.corner[c] = row(std::size_t(leaf.level), grain.corner[c]);
    space.blocks.push_back(made);
    return known = int(space.blocks.size()) - 1;
  }

  bool is_free(int node) const {
    const int slots = slot_count(model.lattice);
    const int slot = node < slots ? node : cells.copy_slot[std::size_t(node - slots)];
    return slot >= 0 && model.inverse_mass[std::size_t(slot)] > 0 && !state.removed[std::size_t(slot)];
  }

  void follow(int node) {
    const CoarseLevel& fine = levels[0];
    if (fine.lies_begin[std::size_t(node)] == fine.lies_begin[std::size_t(node) + 1] || !is_free(node))
      return;
    const int grain = grain_above(0, node);
    space.follows[std::size_t(node)] = grain < 0 ? -2 - row(0, node) : block(leaf_above(levels, 1, grain));
  }

  /// Edges that no cell holds; and nodes that hang on nothing else go with those at the other ends.
  void find_loose_edges() {
    const Lattice& l = model.lattice;
    const auto root = [&](int slot) { return model.root_stiffness[std::size_t(slot)]; };
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (int i = 0; i < l.size.x; i++) {
          const Int3 a{i, j, k};
          const int slot = node_slot(l, a);
          if (!(root(slot) > 0)) continue;
          for (int f = 0; f < kFamilyCount; f++) {
            const Int3 b = a + kFamilies[std::size_t(f)];
            if (!contains(l, b) || !(root(node_slot(l, b)) > 0)) continue;
            if (!is_free(slot) && !is_free(node_slot(l, b))) continue;
            if (state.cut[std::size_t(slot)] >> f & 1) continue;
            if (!is_held_now(model, state, a, kFamilies[std::size_t(f)])) space.loose.push_back({slot, f});
          }
        }
    for (bool any = true; any;) {
      any = false;
      for (const LooseEdge& edge : space.loose) {
        const int other = end_of(l, edge);
        any |= take_along(edge.slot, other) || take_along(other, edge.slot);
      }
    }
    std::sort(space.outside.begin(), space.outside.end());
  }
  bool take_along(int node, int other) {
    int& to = space.follows[std::size_t(node)];
    const int from = space.follows[std::size_t(other)];
    if (to != CoarseSpace::kFixed || from == CoarseSpace::kFixed || !is_free(node)) return false;
    to = from;
    space.outside.push_back(node);
    return true;
  }
};

Runs cells_that_move(const Model& model) {
  return find_runs(model.lattice, [&](int slot) {
    if (!(model.cell_young[std::size_t(slot)] > 0)) return false;
    const int parity = slot_node(model.lattice, slot).x & 1;
    for (int n = 0; n < kCellCorners; n++)
      if (model.inverse_mass[std::size_t(slot + slot_offset(model.lattice, cell_corner(n), parity))] > 0)
        return true;
    return false;
  });
}

}  // namespace

int end_of(const Lattice& l, const LooseEdge& edge) {
  return edge.slot + slot_offset(l, kFamilies[std::size_t(edge.family)], slot_node(l, edge.slot).x & 1);
}

std::shared_ptr<const CoarseSpace> make_coarse_space(const Model& model, const State& state, double dt) {
  FineCells cells = find_cells(model, state);
  std::vector<CoarseLevel> levels;
  levels.push_back(std::move(cells.level));
  while (levels.size() < kLeastLevels ||
         (levels.back().place.size() > kMostNodes && levels.size() < kMostLevels))
    levels.push_back(coarsen(levels.back()));
  std::shared_ptr<CoarseSpace> space;
  for (std::size_t finest = 1; finest <= levels.size(); finest++) {
    space = std::make_shared<CoarseSpace>();
    space->follows.assign(levels[0].place.size(), CoarseSpace::kFixed);
    SpaceBuilder builder(model, state, cells, levels, *space);
    for (int node = 0; node < int(levels[0].place.size()); node++) builder.follow(node);
    builder.find_loose_edges();
    if (std::size_t(space->unknowns) <= kMostUnknowns || finest == levels.size()) break;
    for (Aggregate& grain : levels[finest].aggregates) grain.is_parted = false;
  }
  space->runs = find_follow_runs(model.lattice, space->follows);
  for (int k = 0; k <= model.lattice.size.z; k++) {
    const auto is_below = [k](const FollowRun& run) { return run.first.z < k; };
    const auto begin = std::partition_point(space->runs.begin(), space->runs.end(), is_below);
    space->runs_begin.push_back(int(begin - space->runs.begin()));
  }
  space->version = cut_version(state), space->dt = dt;
  space->cells = cells_that_move(model);
  if (space->unknowns > kTooMany) space->unknowns = 0;
  if (space->unknowns > 0) factor_coarse_space(model, state, levels, cells, *space);
  return space;
}

}  // namespace turgor::lattice
