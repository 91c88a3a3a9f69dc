// A coarse space as lists of which every entry can be worked on at once.
#include "turgor/models/lattice/coarse/coarse_kernels.hpp"

#include <numeric>

namespace turgor::lattice {

namespace {

struct SparseEntry {
  int row = 0, column = 0;
  float value = 0;
};

/// Entries of a row stay in their order.
SparseRows sparse_rows(std::size_t rows, std::span<const SparseEntry> entries) {
  std::vector<int> begin(rows + 1);
  for (const SparseEntry& e : entries) begin[std::size_t(e.row) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  SparseRows out;
  out.terms.resize(entries.size());
  std::vector<int> next = begin;
  for (const SparseEntry& e : entries)
    out.terms[std::size_t(next[std::size_t(e.row)]++)] = {e.column, e.value};
  for (std::size_t row = 0; row < rows; row++) {
    for (int t = begin[row]; t < begin[row + 1]; t += kAddedTogether)
      out.piece_begin.push_back(std::min(t + kAddedTogether, begin[row + 1]));
    out.row_begin.push_back(int(out.piece_begin.size()) - 1);
  }
  return out;
}

/// Followers block by block, in stretches.
void add_followers(const CoarseSpace& space, CoarseLists& out) {
  out.blocks = space.blocks;
  const auto by_blocks = int(space.blocks.size()), rows = int(space.row_begin.size()) - 1;
  const auto block_of = [&](int to) { return to >= 0 ? to : by_blocks - 2 - to; };
  std::vector<int> begin(std::size_t(by_blocks + rows) + 1);
  for (const int to : space.follows)
    if (to != CoarseSpace::kFixed) begin[std::size_t(block_of(to)) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  out.followers.resize(std::size_t(begin.back()));
  std::vector<int> next = begin;
  for (std::size_t node = 0; node < space.follows.size(); node++)
    if (const int to = space.follows[node]; to != CoarseSpace::kFixed)
      out.followers[std::size_t(next[std::size_t(block_of(to))]++)] = int(node);
  for (int row = 0; row < rows; row++) {
    CoarseBlock itself{.low = {}, .size = 1};
    itself.corner.fill(row);
    out.blocks.push_back(itself);
  }
  for (std::size_t b = 0; b + 1 < begin.size(); b++)
    for (int f = begin[b]; f < begin[b + 1]; f += kAddedTogether)
      out.stretches.push_back({int(b), f, std::min(f + kAddedTogether, begin[b + 1])});
}

/// L⁻¹ and Lᵀ⁻¹ D⁻¹. A column of L⁻¹ is nil but at the ancestors of its own number: the first row below a
/// number in L is its parent. [Davis 2006, 4.1]
struct InverseFactor {
  const CoarseFactor& factor;
  std::vector<int> parent, depth;
  std::vector<std::size_t> begin;  // by column, in `value`: from the root of its tree down to itself
  std::vector<float> value;

  explicit InverseFactor(const CoarseFactor& of) : factor(of), parent(of.mobility.size(), -1), depth(parent) {
    begin.resize(parent.size());
    for (std::size_t c = parent.size(); c-- > 0;) {
      const bool is_root = of.column[c] == of.column[c + 1];
      if (!is_root) parent[c] = of.row[of.column[c]];
      depth[c] = is_root ? 0 : depth[std::size_t(parent[c])] + 1;
      begin[c] = value.size();
      value.resize(begin[c] + std::size_t(depth[c]) + 1);
      fill_column(c);
    }
  }
  /// L⁻¹ e = e − Σ L⁻¹ (L − 1) e.
  void fill_column(std::size_t c) {
    float* column = value.data() + begin[c];
    column[depth[c]] = 1;
    for (std::uint32_t p = factor.column[c]; p < factor.column[c + 1]; p++) {
      const std::size_t above = factor.row[p];
      const float* other = value.data() + begin[above];
      const float by = factor.value[p];
      for (int n = 0; n <= depth[above]; n++) column[n] -= by * other[n];
    }
  }
  void write(CoarseLists& out) const {
    std::vector<SparseEntry> lower, upper;
    lower.reserve(value.size()), upper.reserve(value.size());
    for (std::size_t n = 0; n < parent.size(); n++) {
      const int c = factor.order[n];
      for (int row = c; row >= 0; row = parent[std::size_t(row)]) {
        const float entry = value[begin[std::size_t(c)] + std::size_t(depth[std::size_t(row)])];
        lower.push_back({row, int(n), entry});
        upper.push_back({int(n), row, entry * factor.mobility[std::size_t(row)]});
      }
    }
    out.lower = sparse_rows(parent.size(), lower);
    out.upper = sparse_rows(parent.size(), upper);
  }
};

}  // namespace

CoarseLists coarse_lists(const Model& model, const State& state, const CoarseSpace& space) {
  CoarseLists out;
  out.slot_of_virtual_node.resize(state.virtual_nodes.size());
  for (const ElementNode& copy : state.parts.virtual_nodes)
    out.slot_of_virtual_node[std::size_t(copy.corner - slot_count(model.lattice))] = copy.slot;
  add_followers(space, out);

  const auto terms_of = [&](int row) {
    const int begin = space.row_begin[std::size_t(row)];
    return std::span(space.terms)
        .subspan(std::size_t(begin), std::size_t(space.row_begin[std::size_t(row) + 1] - begin));
  };
  std::vector<SparseEntry> to_unknowns, to_corners;
  for (std::size_t s = 0; s < out.stretches.size(); s++)
    for (std::size_t c = 0; c < 8; c++)
      for (const CoarseTerm& t : terms_of(out.blocks[std::size_t(out.stretches[s].block)].corner[c]))
        to_unknowns.push_back({t.unknown, int(8 * s + c), t.weight});
  const auto rows = int(space.row_begin.size()) - 1;
  for (int row = 0; row < rows; row++)
    for (const CoarseTerm& t : terms_of(row)) to_corners.push_back({row, t.unknown, t.weight});
  out.to_unknowns = sparse_rows(std::size_t(space.unknowns), to_unknowns);
  out.to_corners = sparse_rows(std::size_t(rows), to_corners);
  InverseFactor(space.stiffness).write(out);
  return out;
}

}  // namespace turgor::lattice
