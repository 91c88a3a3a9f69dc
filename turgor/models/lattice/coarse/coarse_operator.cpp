// Galerkin operator of the coarse space: linear tissue, skin as in the CT, and inertia of a step. Nearly all
// elements are assembled block by block, since blocks have few corners. Whole cells and inertia are added to
// moments of blocks (block_moments.hpp).
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/block_moments.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/skin_stiffness.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"

namespace turgor::lattice {

namespace {

struct CoarseOperatorBuilder {
  const Model& model;
  const State& state;
  std::span<const CoarseLevel> levels;
  const FineCells& cells;
  const CoarseSpace& space;
  std::vector<std::vector<int>> block_of;  // by level and aggregate; −1: no node uses it
  std::vector<AggregateIndex> leaf_of;     // by aggregate of level 1 (leaf_above)
  std::vector<BlockMatrix> blocks;
  std::vector<BlockMoments> moments;  // by block
  std::vector<Eigen::Triplet<double>> entries;

  CoarseOperatorBuilder(const Model& m, const State& s, std::span<const CoarseLevel> all, const FineCells& c,
                        const CoarseSpace& made)
      : model(m),
        state(s),
        levels(all),
        cells(c),
        space(made),
        blocks(made.blocks.size()),
        moments(made.blocks.size()) {}

  Int3 position(int node) const { return levels[0].position[std::size_t(node)]; }
  bool moves(int node) const { return space.interpolation[std::size_t(node)] != CoarseSpace::kFixed; }

  /// Interpolation of a node from the unknowns.
  std::vector<CoarseTerm> row_of(int node) const {
    const int to = space.interpolation[std::size_t(node)];
    TURGOR_CHECK(to < int(space.blocks.size()), "a node is interpolated from a block of the space");
    std::vector<CoarseTerm> row;
    const auto add = [&](int of, float weight) {
      for (int t = space.row_begin[std::size_t(of)]; t < space.row_begin[std::size_t(of) + 1]; t++)
        row.push_back({space.terms[std::size_t(t)].unknown, space.terms[std::size_t(t)].weight * weight});
    };
    // single node, or corners of its block
    if (to <= -2) add(-2 - to, 1);
    if (to < 0) return row;
    const CoarseBlock& block = space.blocks[std::size_t(to)];
    const std::array<float, 8> weights = corner_weights(block, position(node));
    for (std::size_t c = 0; c < 8; c++)
      if (weights[c] != 0) add(block.corner[c], weights[c]);
    return row;
  }

  void add_entries(std::span<const CoarseTerm> a, std::span<const CoarseTerm> b, const Mat3d& k,
                   double scale = 1) {
    for (const CoarseTerm& p : a)
      for (const CoarseTerm& q : b)
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++) {
            const int row = 3 * p.unknown + i, column = 3 * q.unknown + j;
            if (row >= column)
              entries.emplace_back(row, column, scale * double(p.weight) * double(q.weight) * k.column[j][i]);
          }
  }

  void find_blocks() {
    for (const CoarseLevel& level : levels) block_of.emplace_back(level.aggregates.size(), -1);
    for (std::size_t b = 0; b < space.blocks.size(); b++)
      block_of[std::size_t(space.blocks[b].leaf.level)][std::size_t(space.blocks[b].leaf.aggregate)] = int(b);
    for (std::size_t g = 0; g < levels[1].aggregates.size(); g++)
      leaf_of.push_back(leaf_above(levels, 1, int(g)));
  }

  /// Block of a leaf; −1: none.
  int block_at(AggregateIndex leaf) const {
    return leaf.level < 0 ? -1 : block_of[std::size_t(leaf.level)][std::size_t(leaf.aggregate)];
  }
  /// Block from which all these nodes are interpolated; −1: none.
  int common_source(std::span<const int> nodes) const {
    const int first = space.interpolation[std::size_t(nodes[0])];
    const bool same = std::all_of(nodes.begin(), nodes.end(),
                                  [&](int node) { return space.interpolation[std::size_t(node)] == first; });
    return same && first >= 0 ? first : -1;
  }

  /// Block that contains all these nodes, or from which they are interpolated; −1: none.
  int block_of_all(std::span<const int> nodes) const {
    if (const int source = common_source(nodes); source >= 0) return source;
    const CoarseLevel& fine = levels[0];
    const auto is_member = [&](int node, AggregateIndex leaf) {
      for (int n = fine.membership_begin[std::size_t(node)]; n < fine.membership_begin[std::size_t(node) + 1];
           n++)
        if (leaf_of[std::size_t(fine.memberships[std::size_t(n)])] == leaf) return true;
      return false;
    };
    // blocks that contain the first node
    for (int n = fine.membership_begin[std::size_t(nodes[0])];
         n < fine.membership_begin[std::size_t(nodes[0]) + 1]; n++) {
      const AggregateIndex leaf = leaf_of[std::size_t(fine.memberships[std::size_t(n)])];
      if (leaf.level < 0) continue;
      bool all = true;
      for (const int node : nodes) all = all && is_member(node, leaf);
      if (all) return block_at(leaf);
    }
    return -1;
  }

  /// Adds an element with its nodes and the stiffness `scale` k(a, b) of node pairs. `at`: block_of_all.
  template <class OfPair>
  void add_element(int at, std::span<const int> nodes, const OfPair& of_pair, double scale = 1) {
    TURGOR_CHECK(nodes.size() <= kCellCorners, "an element has at most eight nodes");
    if (at < 0) {
      std::vector<std::vector<CoarseTerm>> rows;
      for (const int node : nodes) rows.push_back(row_of(node));
      for (std::size_t a = 0; a < nodes.size(); a++)
        for (std::size_t b = 0; b < nodes.size(); b++)
          add_entries(rows[a], rows[b], of_pair(int(a), int(b)), scale);
      return;
    }
    add_to_block(at, nodes, of_pair, scale);
  }

  /// Adds an element to the matrix of a block, Wᵀ k W, with W the weights of the block's corners.
  template <class OfPair>
  void add_to_block(int at, std::span<const int> nodes, const OfPair& of_pair, double scale) {
    NodeWeights weights{};
    for (std::size_t n = 0; n < nodes.size(); n++) {
      if (!moves(nodes[n])) continue;
      const std::array<float, 8> w = corner_weights(space.blocks[std::size_t(at)], position(nodes[n]));
      std::copy(w.begin(), w.end(), weights[n].begin());
    }
    add_projected(nodes.size(), weights, of_pair, scale, blocks[std::size_t(at)]);
  }

  /// Block whose moments a whole cell is added to; −1: no block contains it, or one of its nodes is fixed.
  int block_of_whole_cell(std::size_t cell) const {
    const Aggregate& aggregate = levels[0].aggregates[cell];
    const int at = aggregate.is_cut ? -1 : block_at(leaf_of[std::size_t(aggregate.parent)]);
    const bool all_move = std::all_of(aggregate.corner.begin(), aggregate.corner.end(),
                                      [this](int node) { return moves(node); });
    return all_move ? at : -1;
  }
  /// Adds a whole cell with E = `young` to the moments of its block.
  void add_whole_cell(int at, std::size_t cell, double young) {
    const CoarseBlock& block = space.blocks[std::size_t(at)];
    add_moments(Vec3d(levels[0].aggregates[cell].low - block.low) * (1.0 / block.size), young,
                moments[std::size_t(at)].stiffness);
  }

  /// Adds moments to the matrices of blocks.
  void expand_moments(const Exec& exec) {
    std::map<int, BlockBasis> bases;  // by size
    for (const CoarseBlock& block : space.blocks)
      if (!bases.contains(block.size))
        bases.emplace(block.size,
                      block_basis(block.size, model.anatomy.lattice.spacing, model.params.tissue.poisson));
    parallel_for(exec, blocks.size(),
                 [&](std::size_t b) { add_expanded(moments[b], bases.at(space.blocks[b].size), blocks[b]); });
  }

  void add_blocks() {
    constexpr std::size_t kTerms = 700;  // of a block, more than most have
    entries.reserve(entries.size() + kTerms * blocks.size());
    for (std::size_t b = 0; b < blocks.size(); b++)
      for (std::size_t p = 0; p < 8; p++)
        for (std::size_t q = 0; q < 8; q++) {
          Mat3d k = kNothing;
          for (std::size_t i = 0; i < 3; i++)
            for (std::size_t j = 0; j < 3; j++)
              k.column[j][int(i)] = blocks[b][(3 * p + i) * kBlockNumbers + 8 * j + q];
          add_entries(terms_of(space.blocks[b].corner[p]), terms_of(space.blocks[b].corner[q]), k);
        }
  }
  std::span<const CoarseTerm> terms_of(int row) const {
    return std::span(space.terms)
        .subspan(std::size_t(space.row_begin[std::size_t(row)]),
                 std::size_t(space.row_begin[std::size_t(row) + 1] - space.row_begin[std::size_t(row)]));
  }
};

/// Blocks of one thread, whose elements it adds in their order. The first thread also adds the elements that
/// are in no block.
struct OwnBlocks {
  CoarseOperatorBuilder& builder;
  std::size_t thread = 0, threads = 1;

  bool owns(int at) const {
    return at < 0 ? thread == 0 : std::size_t(at) * threads / builder.blocks.size() == thread;
  }
};

Mat3d scaled(const Mat3d& m, double by) { return {{m.column[0] * by, m.column[1] * by, m.column[2] * by}}; }

void add_cells(OwnBlocks own) {
  CoarseOperatorBuilder& builder = own.builder;
  const Model& model = builder.model;
  const std::array<Mat3d, 64> k = cell_stiffness(model.anatomy.lattice.spacing, model.params.tissue.poisson);
  const std::vector<double> instants = instant_factors(model, builder.space.dt);
  const auto& relaxation = model.anatomy.cell_laws.relaxation;
  for (std::size_t g = 0; g < builder.levels[0].aggregates.size(); g++) {
    const std::array<int, 8>& corner = builder.levels[0].aggregates[g].corner;
    const int whole = builder.block_of_whole_cell(g), at = whole < 0 ? builder.block_of_all(corner) : whole;
    if (!own.owns(at)) continue;
    const bool is_cut = builder.levels[0].aggregates[g].is_cut;
    const std::size_t pairs = is_cut || relaxation.empty() ? 0 : relaxation[std::size_t(corner[0])];
    const double young = builder.cells.young[g] * (is_cut ? 1 : instants[pairs]);
    if (whole >= 0)
      builder.add_whole_cell(at, g, young);
    else
      builder.add_element(
          at, corner, [&](int a, int b) -> const Mat3d& { return k[std::size_t(8 * a + b)]; }, young);
  }
}

void add_patches(OwnBlocks own, const SkinStiffness& stiffness) {
  CoarseOperatorBuilder& builder = own.builder;
  const Model& model = builder.model;
  const std::vector<SkinPatch>& patches = model.anatomy.skin.patches;
  const auto add = [&](const SkinPatch& p, std::span<const int> corner, double share) {
    const int at = builder.block_of_all(corner);
    if (!own.owns(at)) return;
    const SkinStiffness::PatchSlopes slopes = stiffness.slopes(p);
    builder.add_element(
        at, corner, [&](int a, int b) { return stiffness(p, slopes, a, b); }, share);
  };
  const CellOffsets offset(model.anatomy.lattice);
  for (std::size_t p = 0; p < patches.size(); p++) {
    if (builder.state.cuts.skin_cut[p]) continue;
    std::array<int, kCellCorners> corner{};
    const int parity = slot_node(model.anatomy.lattice, patches[p].cell).x & 1;
    for (int c = 0; c < kCellCorners; c++) corner[std::size_t(c)] = patches[p].cell + offset.of[parity][c];
    add(patches[p], corner, 1);
  }
  for (const CutCellElement& element : builder.state.cut_elements.cells)
    if (element.patch >= 0)
      add(patches[std::size_t(element.patch)], element.corner, double(element.skin_share));
}

void add_skin(OwnBlocks own) {
  CoarseOperatorBuilder& builder = own.builder;
  const Model& model = builder.model;
  if (model.anatomy.skin.triangles.empty()) return;
  const SkinStiffness stiffness(model);
  if (!model.anatomy.skin.patches.empty()) return add_patches(own, stiffness);
  const auto add = [&](const SkinTriangle& t, Int3 corner, double share) {
    const int nodes[3] = {corner.x, corner.y, corner.z};
    const int at = builder.block_of_all(nodes);
    if (!own.owns(at)) return;
    const std::array<Mat3d, 9> k = stiffness.pairs(t);
    builder.add_element(
        at, nodes, [&](int a, int b) -> const Mat3d& { return k[std::size_t(3 * a + b)]; }, share);
  };
  for (std::size_t t = 0; t < model.anatomy.skin.triangles.size(); t++)
    if (!builder.state.cuts.skin_cut[t])
      add(model.anatomy.skin.triangles[t], model.anatomy.skin.triangles[t].vertex, 1);
  for (const CutSkinElement& element : builder.state.cut_elements.skin)
    add(model.anatomy.skin.triangles[std::size_t(element.triangle)], element.corner, double(element.share));
}

void add_loose_edges(OwnBlocks own) {
  CoarseOperatorBuilder& builder = own.builder;
  const Model& model = builder.model;
  const auto root = [&](int slot) { return double(model.springs.root_stiffness[std::size_t(slot)]); };
  for (const UncoveredEdge& edge : builder.space.loose) {
    const int nodes[2] = {edge.slot, end_of(model.anatomy.lattice, edge)};
    const int at = builder.block_of_all(nodes);
    if (!own.owns(at)) continue;
    const auto family = std::size_t(edge.family);
    const Vec3d d(hadamard(model.anatomy.lattice.spacing, Vec3(kFamilies[family])));
    Mat3d along = kNothing;
    add_outer(along, d, d, double(model.springs.scale[family]) * root(nodes[0]) * root(nodes[1]) / dot(d, d));
    const Mat3d opposite = scaled(along, -1);
    builder.add_element(at, nodes, [&](int a, int b) -> const Mat3d& { return a == b ? along : opposite; });
  }
}

void add_inertia(OwnBlocks own) {
  CoarseOperatorBuilder& builder = own.builder;
  const double h2 = builder.space.dt * builder.space.dt;
  for (int slot = 0; slot < slot_count(builder.model.anatomy.lattice); slot++) {
    if (!builder.moves(slot)) continue;
    const int at = builder.block_of_all({&slot, 1});
    if (!own.owns(at)) continue;
    TURGOR_CHECK(builder.model.anatomy.inverse_mass[std::size_t(slot)] > 0,
                 "a node that moves has a finite mass");
    const double inertia = 1 / (h2 * double(builder.model.anatomy.inverse_mass[std::size_t(slot)]));
    if (builder.space.interpolation[std::size_t(slot)] >= 0) {
      const CoarseBlock& block = builder.space.blocks[std::size_t(at)];
      add_moments(Vec3d(position_in_block(block, builder.position(slot))), inertia,
                  builder.moments[std::size_t(at)].inertia);
      continue;
    }
    Mat3d k = kNothing;
    add_isotropic(k, inertia);
    builder.add_element(at, {&slot, 1}, [&](int, int) -> const Mat3d& { return k; });
  }
}

CoarseFactor factored(const Eigen::SparseMatrix<double>& matrix) {
  // factorization
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> exact(matrix);
  TURGOR_ASSERT(exact.info() == Eigen::Success, "the coarse operator is positive definite");
  TURGOR_ASSERT(matrix.rows() <= 1 << 16, "the coarse space has at most 65536 unknowns");
  // copy in single precision
  const Eigen::SparseMatrix<double>& lower = exact.matrixL().nestedExpression();
  CoarseFactor out;
  out.order.reserve(std::size_t(matrix.cols())), out.inverse_diagonal.reserve(std::size_t(matrix.cols()));
  out.column.reserve(std::size_t(matrix.cols()) + 1);
  out.column.push_back(0);
  out.row.reserve(std::size_t(lower.nonZeros())), out.value.reserve(std::size_t(lower.nonZeros()));
  for (int c = 0; c < int(matrix.cols()); c++) {
    out.order.push_back(exact.permutationP().indices()[c]);
    out.inverse_diagonal.push_back(float(1 / exact.vectorD()[c]));
    for (Eigen::SparseMatrix<double>::InnerIterator at(lower, c); at; ++at)
      if (at.row() > c) out.row.push_back(std::uint16_t(at.row())), out.value.push_back(float(at.value()));
    out.column.push_back(std::uint32_t(out.row.size()));
  }
  TURGOR_CHECK(is_permutation(out.order, std::size_t(matrix.cols())),
               "the order of the unknowns is a permutation");
  TURGOR_CHECK(
      std::all_of(out.inverse_diagonal.begin(), out.inverse_diagonal.end(), [](float m) { return m > 0; }),
      "the diagonal of the coarse factor is positive");
  return out;
}

}  // namespace

void assemble_coarse_operator(const Model& model, const State& state, std::span<const CoarseLevel> levels,
                              const FineCells& cells, CoarseSpace& space, const Exec& exec) {
  CoarseOperatorBuilder builder(model, state, levels, cells, space);
  // elements, then their moments; every block adds its elements in the same order
  builder.find_blocks();
  const auto threads = std::size_t(exec.threads());
  parallel_for(exec, threads, [&](std::size_t thread) {
    const OwnBlocks own{builder, thread, threads};
    add_cells(own);
    add_skin(own);
    add_loose_edges(own);
    add_inertia(own);
  });
  builder.expand_moments(exec);
  // operator
  builder.add_blocks();
  const int count = 3 * space.unknowns;
  // Corners of blocks with few nodes may be linearly dependent, so the diagonal is regularized.
  constexpr double kLeast = 1e-9;
  double largest = 0;
  for (const auto& entry : builder.entries)
    if (entry.row() == entry.col()) largest = std::max(largest, entry.value());
  TURGOR_CHECK(largest > 0, "the diagonal of the coarse operator is positive");
  for (int i = 0; i < count; i++) builder.entries.emplace_back(i, i, kLeast * largest);
  // factorization
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(builder.entries.begin(), builder.entries.end());
  space.factor = factored(matrix);
}

std::vector<double> CoarseFactor::solve(std::span<const double> forces) const {
  TURGOR_CHECK(forces.size() == order.size() && column.size() == order.size() + 1,
               "the factor has a row for every number");
  // forward substitution
  std::vector<double> x(forces.size()), out(forces.size());
  for (std::size_t n = 0; n < x.size(); n++) x[std::size_t(order[n])] = forces[n];
  for (std::size_t c = 0; c < x.size(); c++)
    for (std::uint32_t p = column[c]; p < column[c + 1]; p++) x[row[p]] -= double(value[p]) * x[c];
  // diagonal and backward substitution
  for (std::size_t n = 0; n < x.size(); n++) x[n] *= double(inverse_diagonal[n]);
  for (std::size_t c = x.size(); c-- > 0;)
    for (std::uint32_t p = column[c]; p < column[c + 1]; p++) x[c] -= double(value[p]) * x[row[p]];
  for (std::size_t n = 0; n < x.size(); n++) out[n] = x[std::size_t(order[n])];
  return out;
}

}  // namespace turgor::lattice
