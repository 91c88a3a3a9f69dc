// Lists of a coarse space whose entries are independent.
#include "turgor/models/lattice/coarse/coarse_kernels.hpp"

#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

namespace {

struct SparseEntry {
  int row = 0, column = 0;
  float value = 0;
};

/// Sorts entries by row; the order within a row is kept.
SparseRows sparse_rows(std::size_t rows, std::span<const SparseEntry> entries) {
  TURGOR_CHECK(std::all_of(entries.begin(), entries.end(),
                           [rows](const SparseEntry& e) { return is_index(e.row, rows); }),
               "entries lie in the rows of the matrix");
  // counts
  std::vector<int> begin(rows + 1);
  for (const SparseEntry& e : entries) begin[std::size_t(e.row) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  TURGOR_CHECK(is_csr(begin, entries.size()), "the rows cover all entries");
  // terms by row
  SparseRows out;
  out.terms.resize(entries.size());
  std::vector<int> next = begin;
  for (const SparseEntry& e : entries)
    out.terms[std::size_t(next[std::size_t(e.row)]++)] = {e.column, e.value};
  // segments
  for (std::size_t row = 0; row < rows; row++) {
    for (int t = begin[row]; t < begin[row + 1]; t += kTermsPerThread)
      out.segment_begin.push_back(std::min(t + kTermsPerThread, begin[row + 1]));
    out.row_begin.push_back(int(out.segment_begin.size()) - 1);
  }
  return out;
}

/// Lists the interpolated nodes by block, split into chunks.
void add_fine_nodes(const CoarseSpace& space, CoarseLists& out) {
  out.blocks = space.blocks;
  // count nodes by block
  const auto block_count = int(space.blocks.size()), rows = int(space.row_begin.size()) - 1;
  const auto block_of = [&](int source) { return source >= 0 ? source : block_count - 2 - source; };
  std::vector<int> begin(std::size_t(block_count + rows) + 1);
  for (const int source : space.interpolation)
    if (source != CoarseSpace::kFixed) begin[std::size_t(block_of(source)) + 1]++;
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  // list nodes by block
  out.fine_nodes.resize(std::size_t(begin.back()));
  std::vector<int> next = begin;
  for (std::size_t node = 0; node < space.interpolation.size(); node++)
    if (const int source = space.interpolation[node]; source != CoarseSpace::kFixed)
      out.fine_nodes[std::size_t(next[std::size_t(block_of(source))]++)] = int(node);
  // blocks of single nodes
  for (int row = 0; row < rows; row++) {
    CoarseBlock itself{.low = {}, .size = 1};
    itself.corner.fill(row);
    out.blocks.push_back(itself);
  }
  // chunks
  for (std::size_t b = 0; b + 1 < begin.size(); b++)
    for (int f = begin[b]; f < begin[b + 1]; f += kTermsPerThread)
      out.chunks.push_back({int(b), f, std::min(f + kTermsPerThread, begin[b + 1])});
}

/// Inverse factors L⁻¹ and Lᵀ⁻¹ D⁻¹. A column of L⁻¹ is nonzero only at the ancestors of its index in the
/// elimination tree. The parent is the first row below the diagonal in L. [Davis 2006, 4.1]
struct InverseFactor {
  const CoarseFactor& factor;
  std::vector<int> parent, depth;
  std::vector<std::size_t> begin;  // by column, into `value`: from the root of its tree to itself
  std::vector<float> value;

  explicit InverseFactor(const CoarseFactor& of)
      : factor(of), parent(of.inverse_diagonal.size(), -1), depth(parent) {
    TURGOR_CHECK(of.column.size() == of.inverse_diagonal.size() + 1 && is_csr(of.column, of.row.size()),
                 "the columns cover all entries of the factor");
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
  /// L⁻¹ e = e − Σ L⁻¹ (L − I) e.
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
        upper.push_back({int(n), row, entry * factor.inverse_diagonal[std::size_t(row)]});
      }
    }
    out.lower = sparse_rows(parent.size(), lower);
    out.upper = sparse_rows(parent.size(), upper);
  }
};

}  // namespace

CoarseLists coarse_lists(const Model& model, const CutElements& elements, std::size_t virtual_nodes,
                         const CoarseSpace& space) {
  TURGOR_CHECK(space.interpolation.size() == std::size_t(slot_count(model.anatomy.lattice)) + virtual_nodes,
               "every node and virtual node has an interpolation");
  CoarseLists out;
  // lattice nodes of virtual nodes
  out.slot_of_virtual_node.resize(virtual_nodes);
  for (const ElementNode& virtual_node : elements.virtual_nodes)
    out.slot_of_virtual_node[std::size_t(virtual_node.corner - slot_count(model.anatomy.lattice))] =
        virtual_node.slot;
  add_fine_nodes(space, out);

  const auto terms_of = [&](int row) {
    const int begin = space.row_begin[std::size_t(row)];
    return std::span(space.terms)
        .subspan(std::size_t(begin), std::size_t(space.row_begin[std::size_t(row) + 1] - begin));
  };
  // restriction
  std::vector<SparseEntry> to_unknowns, to_corners;
  for (std::size_t s = 0; s < out.chunks.size(); s++)
    for (std::size_t c = 0; c < 8; c++)
      for (const CoarseTerm& t : terms_of(out.blocks[std::size_t(out.chunks[s].block)].corner[c]))
        to_unknowns.push_back({t.unknown, int(8 * s + c), t.weight});
  // prolongation
  const auto rows = int(space.row_begin.size()) - 1;
  for (int row = 0; row < rows; row++)
    for (const CoarseTerm& t : terms_of(row)) to_corners.push_back({row, t.unknown, t.weight});
  out.to_unknowns = sparse_rows(std::size_t(space.unknowns), to_unknowns);
  out.to_corners = sparse_rows(std::size_t(rows), to_corners);
  // factor
  InverseFactor(space.factor).write(out);
  return out;
}

}  // namespace turgor::lattice
