// Interpolation of nodes from the unknowns of a coarse space.
#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/prolongation.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Blocks have four cells per side, and are doubled until at most kMostNodes corners remain. Sweeps handle
/// errors over up to four cells well. Blocks of two cost four times as much and leave half the error.
constexpr std::size_t kLeastLevels = 3, kMostLevels = 6, kMostNodes = 1000;
/// Limit including blocks next to cuts. Above it, cut tissue uses larger blocks.
constexpr std::size_t kMostUnknowns = 3000;
/// Bodies with more unknowns than this have no coarse space.
constexpr int kTooMany = 20000;

struct SpaceBuilder {
  const Model& model;
  const State& state;
  const FineCells& cells;
  std::span<const CoarseLevel> levels;
  CoarseSpace& space;
  std::vector<std::vector<int>> row_of, block_of;  // by level: of its nodes and its aggregates; −1 = not yet

  SpaceBuilder(const Model& m, const State& s, const FineCells& c, std::span<const CoarseLevel> all,
               CoarseSpace& out)
      : model(m), state(s), cells(c), levels(all), space(out) {
    space.row_begin = {0};
    for (const CoarseLevel& level : levels) {
      row_of.emplace_back(level.position.size(), -1);
      block_of.emplace_back(level.aggregates.size(), -1);
    }
  }

  int add_row(std::span<const CoarseTerm> terms) {
    space.terms.insert(space.terms.end(), terms.begin(), terms.end());
    space.row_begin.push_back(int(space.terms.size()));
    return int(space.row_begin.size()) - 2;
  }

  /// Uncut aggregate of the next level that contains a node; −1: none, the node is an unknown.
  int aggregate_above(std::size_t level, int node) const {
    const CoarseLevel& current = levels[level];
    if (level + 1 == levels.size()) return -1;
    for (int n = current.membership_begin[std::size_t(node)];
         n < current.membership_begin[std::size_t(node) + 1]; n++)
      if (const int g = current.memberships[std::size_t(n)];
          !levels[level + 1].aggregates[std::size_t(g)].is_cut)
        return g;
    return -1;
  }

  /// Row with the interpolation of a node of a level from the unknowns.
  int row(std::size_t level, int node) {
    int& cached = row_of[level][std::size_t(node)];
    if (cached >= 0) return cached;
    // unknown
    const int above = aggregate_above(level, node);
    if (above < 0) {
      const CoarseTerm itself{space.unknowns++, 1};
      return cached = add_row({&itself, 1});
    }
    // sum over the corners of the aggregate above
    const Aggregate& aggregate = levels[level + 1].aggregates[std::size_t(above)];
    const std::array<float, 8> weights =
        corner_weights({.low = aggregate.low * 2, .size = 2}, levels[level].position[std::size_t(node)]);
    std::vector<CoarseTerm> sum;
    for (std::size_t c = 0; c < 8; c++) {
      if (weights[c] == 0) continue;
      const auto of = std::size_t(row(level + 1, aggregate.corner[c]));
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
    TURGOR_CHECK(
        std::abs(std::accumulate(sum.begin(), sum.end(), 0.0,
                                 [](double a, const CoarseTerm& t) { return a + double(t.weight); }) -
                 1) < 1e-4,
        "the weights of a node sum to one");
    return cached = add_row(sum);
  }

  int block(AggregateIndex leaf) {
    int& cached = block_of[std::size_t(leaf.level)][std::size_t(leaf.aggregate)];
    if (cached >= 0) return cached;
    const Aggregate& aggregate = levels[std::size_t(leaf.level)].aggregates[std::size_t(leaf.aggregate)];
    CoarseBlock made{.low = aggregate.low * (1 << leaf.level), .size = 1 << leaf.level, .leaf = leaf};
    for (std::size_t c = 0; c < 8; c++) made.corner[c] = row(std::size_t(leaf.level), aggregate.corner[c]);
    space.blocks.push_back(made);
    return cached = int(space.blocks.size()) - 1;
  }

  bool is_free(int node) const {
    const int slots = slot_count(model.anatomy.lattice);
    const int slot = node < slots ? node : cells.virtual_node_slot[std::size_t(node - slots)];
    if (slot < 0 || model.anatomy.inverse_mass[std::size_t(slot)] == 0) return false;
    const std::uint8_t removed = state.cuts.removed[std::size_t(slot)];
    return removed == 0 || (removed == kExcised && node >= slots);
  }

  void add_node(int node) {
    const CoarseLevel& fine = levels[0];
    if (fine.membership_begin[std::size_t(node)] == fine.membership_begin[std::size_t(node) + 1] ||
        !is_free(node))
      return;
    const int aggregate = aggregate_above(0, node);
    space.interpolation[std::size_t(node)] =
        aggregate < 0 ? -2 - row(0, node) : block(leaf_above(levels, 1, aggregate));
  }

  /// False: no blade is near the node, and the elements around it cover its edges.
  bool may_have_loose_edge(int slot) const {
    return !model.anatomy.cell_center.empty() ||
           state.cuts.row_cut[std::size_t(slot / row_stride(model.anatomy.lattice))] ||
           model.vbd.incident_elements[std::size_t(slot / kGroup)] == IncidentElements::kSprings;
  }

  /// Finds loose edges. Nodes without other elements use the interpolation of the node at the other end.
  void find_loose_edges() {
    const Lattice& l = model.anatomy.lattice;
    const auto root = [&](int slot) { return model.springs.root_stiffness[std::size_t(slot)]; };
    // loose edges
    for (int k = 0; k < l.size.z; k++)
      for (int j = 0; j < l.size.y; j++)
        for (int i = 0; i < l.size.x; i++) {
          const Int3 a{i, j, k};
          const int slot = node_slot(l, a);
          if (!(root(slot) > 0) || !may_have_loose_edge(slot)) continue;
          for (int f = 0; f < kFamilyCount; f++) {
            const Int3 b = a + kFamilies[std::size_t(f)];
            if (!contains(l, b) || !(root(node_slot(l, b)) > 0)) continue;
            if (!is_free(slot) && !is_free(node_slot(l, b))) continue;
            if (state.cuts.cut[std::size_t(slot)] >> f & 1) continue;
            if (!is_edge_covered(model, state.cuts, a, kFamilies[std::size_t(f)]))
              space.loose.push_back({slot, f});
          }
        }
    // nodes with loose edges only
    for (bool any = true; any;) {
      any = false;
      for (const UncoveredEdge& edge : space.loose) {
        const int other = end_of(l, edge);
        any |= attach(edge.slot, other) || attach(other, edge.slot);
      }
    }
    std::sort(space.outside.begin(), space.outside.end());
  }
  bool attach(int node, int other) {
    int& to = space.interpolation[std::size_t(node)];
    const int from = space.interpolation[std::size_t(other)];
    if (to != CoarseSpace::kFixed || from == CoarseSpace::kFixed || !is_free(node)) return false;
    to = from;
    space.outside.push_back(node);
    return true;
  }
};

Runs cells_with_free_nodes(const Model& model) {
  return find_runs(model.anatomy.lattice, [&](int slot) {
    if (!(model.anatomy.cell_young[std::size_t(slot)] > 0)) return false;
    const int parity = slot_node(model.anatomy.lattice, slot).x & 1;
    for (int n = 0; n < kCellCorners; n++)
      if (model.anatomy
              .inverse_mass[std::size_t(slot + slot_offset(model.anatomy.lattice, cell_corner(n), parity))] >
          0)
        return true;
    return false;
  });
}

}  // namespace

int end_of(const Lattice& l, const UncoveredEdge& edge) {
  return edge.slot + slot_offset(l, kFamilies[std::size_t(edge.family)], slot_node(l, edge.slot).x & 1);
}

std::shared_ptr<const CoarseSpace> make_coarse_space(const Model& model, const State& state, double dt,
                                                     const Exec& exec) {
  // levels
  TURGOR_ASSERT(is_step_length(dt), "a coarse space is built for a step of positive length");
  FineCells cells = find_fine_cells(model, state);
  std::vector<CoarseLevel> levels;
  levels.push_back(std::move(cells.level));
  while (levels.size() < kLeastLevels ||
         (levels.back().position.size() > kMostNodes && levels.size() < kMostLevels))
    levels.push_back(coarsen(levels.back()));
  // interpolation; with too many unknowns, cut tissue uses larger blocks
  std::shared_ptr<CoarseSpace> space;
  for (std::size_t finest = 1; finest <= levels.size(); finest++) {
    space = std::make_shared<CoarseSpace>();
    space->interpolation.assign(levels[0].position.size(), CoarseSpace::kFixed);
    SpaceBuilder builder(model, state, cells, levels, *space);
    for (int node = 0; node < int(levels[0].position.size()); node++) builder.add_node(node);
    builder.find_loose_edges();
    if (std::size_t(space->unknowns) <= kMostUnknowns || finest == levels.size()) break;
    for (Aggregate& aggregate : levels[finest].aggregates) aggregate.is_cut = false;
  }
  // runs by layer
  space->runs = find_prolongation_runs(model.anatomy.lattice, space->interpolation);
  space->run_weights = weights_of_runs(*space);
  for (int k = 0; k <= model.anatomy.lattice.size.z; k++) {
    const auto is_below = [k](const ProlongationRun& run) { return run.first.z < k; };
    const auto begin = std::partition_point(space->runs.begin(), space->runs.end(), is_below);
    space->runs_begin.push_back(int(begin - space->runs.begin()));
  }
  // operator
  space->version = cut_version(state.cuts), space->dt = dt;
  TURGOR_CHECK(is_csr(space->row_begin, space->terms.size()) && is_csr(space->runs_begin, space->runs.size()),
               "the rows cover all terms, and the layers cover all runs");
  TURGOR_CHECK(is_ascending(space->runs, &ProlongationRun::slot), "runs ascend by slot");
  space->cells = cells_with_free_nodes(model);
  if (space->unknowns > kTooMany) space->unknowns = 0;
  if (space->unknowns > 0) assemble_coarse_operator(model, state, levels, cells, *space, exec);
  return space;
}

}  // namespace turgor::lattice
