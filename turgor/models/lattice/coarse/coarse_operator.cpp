// Galerkin operator of the coarse space: linear tissue, skin as in the CT, and inertia of a step. Nearly all
// elements are assembled block by block, since blocks have few corners.
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"

namespace turgor::lattice {

namespace {

constexpr int kSides = 24;  // degrees of freedom of a block
constexpr Mat3d kNothing{{Vec3d{}, Vec3d{}, Vec3d{}}};
using BlockMatrix = std::array<double, kSides * kSides>;

struct CoarseOperatorBuilder {
  const Model& model;
  const State& state;
  std::span<const CoarseLevel> levels;
  const FineCells& cells;
  const CoarseSpace& space;
  std::vector<std::vector<int>> block_of;  // by level and aggregate; −1: no node uses it
  std::vector<BlockMatrix> blocks;
  std::vector<Eigen::Triplet<double>> entries;

  CoarseOperatorBuilder(const Model& m, const State& s, std::span<const CoarseLevel> all, const FineCells& c,
                        const CoarseSpace& made)
      : model(m), state(s), levels(all), cells(c), space(made), blocks(made.blocks.size()) {}

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

  void add_entries(std::span<const CoarseTerm> a, std::span<const CoarseTerm> b, const Mat3d& k) {
    for (const CoarseTerm& p : a)
      for (const CoarseTerm& q : b)
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++) {
            const int row = 3 * p.unknown + i, column = 3 * q.unknown + j;
            if (row >= column)
              entries.emplace_back(row, column, double(p.weight) * double(q.weight) * k.column[j][i]);
          }
  }

  void find_blocks() {
    for (const CoarseLevel& level : levels) block_of.emplace_back(level.aggregates.size(), -1);
    for (std::size_t b = 0; b < space.blocks.size(); b++)
      block_of[std::size_t(space.blocks[b].leaf.level)][std::size_t(space.blocks[b].leaf.aggregate)] = int(b);
  }

  /// Block that contains all these nodes; −1: none.
  int block_of_all(std::span<const int> nodes) const {
    const CoarseLevel& fine = levels[0];
    const auto is_member = [&](int node, AggregateIndex leaf) {
      for (int n = fine.membership_begin[std::size_t(node)]; n < fine.membership_begin[std::size_t(node) + 1];
           n++)
        if (leaf_above(levels, 1, fine.memberships[std::size_t(n)]) == leaf) return true;
      return false;
    };
    // blocks that contain the first node
    for (int n = fine.membership_begin[std::size_t(nodes[0])];
         n < fine.membership_begin[std::size_t(nodes[0]) + 1]; n++) {
      const AggregateIndex leaf = leaf_above(levels, 1, fine.memberships[std::size_t(n)]);
      if (leaf.level < 0) continue;
      bool all = true;
      for (const int node : nodes) all = all && is_member(node, leaf);
      if (all) return block_of[std::size_t(leaf.level)][std::size_t(leaf.aggregate)];
    }
    return -1;
  }

  /// Adds an element with its nodes and the stiffness k(a, b) of node pairs.
  template <class OfPair>
  void add_element(std::span<const int> nodes, const OfPair& of_pair) {
    TURGOR_CHECK(nodes.size() <= kCellCorners, "an element has at most eight nodes");
    const int at = block_of_all(nodes);
    if (at < 0) {
      std::vector<std::vector<CoarseTerm>> rows;
      for (const int node : nodes) rows.push_back(row_of(node));
      for (std::size_t a = 0; a < nodes.size(); a++)
        for (std::size_t b = 0; b < nodes.size(); b++) add_entries(rows[a], rows[b], of_pair(int(a), int(b)));
      return;
    }
    add_to_block(at, nodes, of_pair);
  }

  /// Adds an element to the matrix of a block, Wᵀ k W, with W the weights of the block's corners.
  template <class OfPair>
  void add_to_block(int at, std::span<const int> nodes, const OfPair& of_pair) {
    // weights of the corners at each node
    std::array<std::array<float, 8>, kCellCorners> weights{};
    for (std::size_t n = 0; n < nodes.size(); n++)
      if (moves(nodes[n])) weights[n] = corner_weights(space.blocks[std::size_t(at)], position(nodes[n]));
    BlockMatrix& sum = blocks[std::size_t(at)];
    // Wᵀ k W, node by node
    for (std::size_t a = 0; a < nodes.size(); a++) {
      if (!moves(nodes[a])) continue;
      double by_corner[3][kSides] = {};
      for (std::size_t b = 0; b < nodes.size(); b++) {
        const Mat3d k = of_pair(int(a), int(b));
        for (std::size_t q = 0; q < 8; q++)
          for (std::size_t j = 0; j < 3; j++)
            for (int i = 0; i < 3; i++) by_corner[i][3 * q + j] += double(weights[b][q]) * k.column[j][i];
      }
      for (std::size_t p = 0; p < 8; p++) {
        const double w = weights[a][p];
        if (w == 0) continue;
        for (std::size_t i = 0; i < 3; i++)
          for (std::size_t n = 0; n < kSides; n++) sum[(3 * p + i) * kSides + n] += w * by_corner[i][n];
      }
    }
  }

  void add_blocks() {
    for (std::size_t b = 0; b < blocks.size(); b++)
      for (std::size_t p = 0; p < 8; p++)
        for (std::size_t q = 0; q < 8; q++) {
          Mat3d k = kNothing;
          for (std::size_t i = 0; i < 3; i++)
            for (std::size_t j = 0; j < 3; j++)
              k.column[j][int(i)] = blocks[b][(3 * p + i) * kSides + 3 * q + j];
          add_entries(terms_of(space.blocks[b].corner[p]), terms_of(space.blocks[b].corner[q]), k);
        }
  }
  std::span<const CoarseTerm> terms_of(int row) const {
    return std::span(space.terms)
        .subspan(std::size_t(space.row_begin[std::size_t(row)]),
                 std::size_t(space.row_begin[std::size_t(row) + 1] - space.row_begin[std::size_t(row)]));
  }
};

/// Stiffness of pairs of corners of a cell with E = 1: linear elasticity at the center and the hourglass
/// stiffness.
///   k_ab = V (µ g_b g_aᵀ + λ g_a g_bᵀ + µ (g_a · g_b) I) + V κ/8 (δ_ab − (1 + s_a · s_b)/8) I
/// g: gradient of the shape function, s: signs of the corner. This is the Hessian of add_cell at rest.
std::array<Mat3d, 64> cell_stiffness(Vec3 spacing, double poisson) {
  TURGOR_CHECK(poisson >= 0 && poisson < 0.5, "Poisson's ratio is from 0 to below 0.5");
  // Lame parameters for a Young's modulus of 1
  const Vec3d h(spacing);
  const double volume = h.x * h.y * h.z, mu = 0.5 / (1 + poisson),
               lambda = poisson / ((1 + poisson) * (1 - 2 * poisson)),
               hourglass = double(solid_law(spacing, poisson).hourglass);
  std::array<Mat3d, 64> k{};
  // blocks of all corner pairs
  for (int a = 0; a < 8; a++)
    for (int b = 0; b < 8; b++) {
      // shape function gradients at the cell center
      const Vec3d sa(corner_sign(a)), sb(corner_sign(b));
      const Vec3d ga = Vec3d{sa.x / h.x, sa.y / h.y, sa.z / h.z} * 0.25,
                  gb = Vec3d{sb.x / h.x, sb.y / h.y, sb.z / h.z} * 0.25;
      // diagonal share: shear and hourglass stiffness
      const double alike = volume * mu * dot(ga, gb) + hourglass * ((a == b ? 1 : 0) - (1 + dot(sa, sb)) / 8);
      // add the elastic block
      Mat3d& m = k[std::size_t(8 * a + b)];
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          m.column[std::size_t(j)][i] =
              volume * (mu * gb[i] * ga[j] + lambda * ga[i] * gb[j]) + (i == j ? alike : 0);
    }
  return k;
}

Mat3d scaled(const Mat3d& m, double by) { return {{m.column[0] * by, m.column[1] * by, m.column[2] * by}}; }
void add_outer(Mat3d& m, Vec3d a, Vec3d b, double by) {
  for (int j = 0; j < 3; j++) m.column[std::size_t(j)] = m.column[std::size_t(j)] + a * (b[j] * by);
}
void add_isotropic(Mat3d& m, double by) {
  for (int j = 0; j < 3; j++) m.column[std::size_t(j)][j] += by;
}

/// Stiffness of pairs of corners of a triangle as in the CT, positive semidefinite like the Hessians of VBD
/// (add_skin_fiber, add_skin_area).
struct SkinStiffness {
  const Model& model;
  FiberLaw law;
  SkinTangent tangent;  // exponential law

  explicit SkinStiffness(const Model& m) : model(m), law(fiber_law(m.params.skin)) {
    if (m.params.skin.law == SkinLaw::kExponential)
      tangent = skin_tangent(m.params.skin, stretch_of_tension(m.params.skin).value_or(SkinStretch{}));
  }

  Mat3d operator()(const SkinTriangle& t, int a, int b) const {
    if (model.params.skin.law == SkinLaw::kExponential) return tangent_stiffness(t, a, b);
    return model.params.skin.law == SkinLaw::kFiber ? fiber_stiffness(t, a, b) : area_stiffness(t, a, b);
  }
  Mat3d fiber_stiffness(const SkinTriangle& t, int a, int b) const {
    const Vec3d e1(t.edge1), e2(t.edge2);
    const Vec3d f = e1 * double(t.along[1]) + e2 * double(t.along[2]),
                g = e1 * double(t.across[1]) + e2 * double(t.across[2]);
    Mat3d k = kNothing;
    add_fiber(k, f, double(t.along[a]) * double(t.along[b]), double(law.rest_along), t.area);
    add_fiber(k, g, double(t.across[a]) * double(t.across[b]), double(law.rest_across), t.area);
    const Vec3d sheared_a = f * double(t.across[a]) + g * double(t.along[a]),
                sheared_b = f * double(t.across[b]) + g * double(t.along[b]);
    add_outer(k, sheared_a, sheared_b, double(law.shear) * double(t.area));
    return k;
  }
  /// Strains along e and across g, and their tension: the tangent of the law at the tension of the CT.
  Mat3d tangent_stiffness(const SkinTriangle& t, int a, int b) const {
    const Vec3d e1(t.edge1), e2(t.edge2);
    const Vec3d e = e1 * double(t.along[1]) + e2 * double(t.along[2]),
                g = e1 * double(t.across[1]) + e2 * double(t.across[2]);
    const double area = double(t.area), xa = double(t.along[a]), xb = double(t.along[b]),
                 ya = double(t.across[a]), yb = double(t.across[b]);
    Mat3d k = kNothing;
    add_outer(k, e, e, area * tangent.along * xa * xb);
    add_outer(k, g, g, area * tangent.across * ya * yb);
    add_outer(k, e, g, area * tangent.coupling * xa * yb);
    add_outer(k, g, e, area * tangent.coupling * ya * xb);
    add_outer(k, e * ya + g * xa, e * yb + g * xb, area * tangent.shear);
    add_isotropic(k, area * (tangent.tension_along * xa * xb + tangent.tension_across * ya * yb));
    return k;
  }
  /// The same for corners a and b of the cell of a patch.
  Mat3d operator()(const SkinPatch& p, int a, int b) const {
    const Vec3 slope = solid_law(model.anatomy.lattice.spacing, 0).slope;
    const double area = double(p.area) / kPatchPoints;
    Mat3d k = kNothing;
    for (int n = 0; n < kPatchPoints; n++) {
      const Vec3 point = patch_point(p, n);
      const Vec3d f(p.along), g(p.across), at_a(shape_gradient(a, slope, point)),
          at_b(shape_gradient(b, slope, point));
      add_fiber(k, f, dot(at_a, f) * dot(at_b, f), double(law.rest_along), area);
      add_fiber(k, g, dot(at_a, g) * dot(at_b, g), double(law.rest_across), area);
      add_outer(k, f * dot(at_a, g) + g * dot(at_a, f), f * dot(at_b, g) + g * dot(at_b, f),
                double(law.shear) * area);
    }
    return k;
  }
  void add_fiber(Mat3d& k, Vec3d g, double share, double rest, double area) const {
    TURGOR_CHECK(norm(g) > 0 && rest > 0, "a fiber has a length");
    const double length = norm(g), strain = std::max(0.0, length - rest);
    const double stiffness =
        double(law.stiffness) * area * share * (1 + double(law.amplification) * strain / rest);
    const double lateral = stiffness * strain / length;
    add_outer(k, g, g, (stiffness - lateral) / (length * length));
    add_isotropic(k, lateral);
  }
  Mat3d area_stiffness(const SkinTriangle& t, int a, int b) const {
    TURGOR_CHECK(t.area > 0, "a skin triangle has an area in the CT");
    const Vec3d position[3] = {{}, Vec3d(t.edge1), Vec3d(t.edge2)};
    const Vec3d n = cross(position[1], position[2]), u = n * (1 / norm(n));
    const double ratio = double(rest_area_ratio(model.params.skin)), growth = 1 / ratio - 1;
    const double stiffness =
        model.params.skin.stiffness / (ratio * t.area) * (1 + model.params.skin.amplification * growth);
    const auto opposite = [&](int c) { return position[(c + 1) % 3] - position[(c + 2) % 3]; };
    const Vec3d ga = cross(opposite(a), u) * 0.5, gb = cross(opposite(b), u) * 0.5;
    Mat3d k = kNothing;
    add_outer(k, ga, gb, stiffness);
    add_outer(k, u, u, stiffness * (1 - ratio) * t.area * dot(opposite(a), opposite(b)) / (2 * norm(n)));
    return k;
  }
};

void add_cells(CoarseOperatorBuilder& builder) {
  const Model& model = builder.model;
  const std::array<Mat3d, 64> k = cell_stiffness(model.anatomy.lattice.spacing, model.params.tissue.poisson);
  const double instant = instant_factor(model.params.tissue.prony, builder.space.dt);
  for (std::size_t g = 0; g < builder.levels[0].aggregates.size(); g++) {
    const std::array<int, 8>& corner = builder.levels[0].aggregates[g].corner;
    const double young = builder.cells.young[g] * (builder.levels[0].aggregates[g].is_cut ? 1 : instant);
    builder.add_element(corner, [&](int a, int b) { return scaled(k[std::size_t(8 * a + b)], young); });
  }
}

void add_patches(CoarseOperatorBuilder& builder, const SkinStiffness& stiffness) {
  const Model& model = builder.model;
  const std::vector<SkinPatch>& patches = model.anatomy.skin.patches;
  const auto add = [&](const SkinPatch& p, std::span<const int> corner, double share) {
    builder.add_element(corner, [&](int a, int b) { return scaled(stiffness(p, a, b), share); });
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

void add_skin(CoarseOperatorBuilder& builder) {
  const Model& model = builder.model;
  if (model.anatomy.skin.triangles.empty()) return;
  const SkinStiffness stiffness(model);
  if (!model.anatomy.skin.patches.empty()) return add_patches(builder, stiffness);
  const auto add = [&](const SkinTriangle& t, Int3 corner, double share) {
    const int nodes[3] = {corner.x, corner.y, corner.z};
    builder.add_element(nodes, [&](int a, int b) { return scaled(stiffness(t, a, b), share); });
  };
  for (std::size_t t = 0; t < model.anatomy.skin.triangles.size(); t++)
    if (!builder.state.cuts.skin_cut[t])
      add(model.anatomy.skin.triangles[t], model.anatomy.skin.triangles[t].vertex, 1);
  for (const CutSkinElement& element : builder.state.cut_elements.skin)
    add(model.anatomy.skin.triangles[std::size_t(element.triangle)], element.corner, double(element.share));
}

void add_loose_edges(CoarseOperatorBuilder& builder) {
  const Model& model = builder.model;
  const auto root = [&](int slot) { return double(model.springs.root_stiffness[std::size_t(slot)]); };
  for (const UncoveredEdge& edge : builder.space.loose) {
    const int nodes[2] = {edge.slot, end_of(model.anatomy.lattice, edge)};
    const auto family = std::size_t(edge.family);
    const Vec3d d(hadamard(model.anatomy.lattice.spacing, Vec3(kFamilies[family])));
    Mat3d along = kNothing;
    add_outer(along, d, d, double(model.springs.scale[family]) * root(nodes[0]) * root(nodes[1]) / dot(d, d));
    builder.add_element(nodes, [&](int a, int b) { return scaled(along, a == b ? 1 : -1); });
  }
}

void add_inertia(CoarseOperatorBuilder& builder) {
  const double h2 = builder.space.dt * builder.space.dt;
  for (int slot = 0; slot < slot_count(builder.model.anatomy.lattice); slot++) {
    if (!builder.moves(slot)) continue;
    TURGOR_CHECK(builder.model.anatomy.inverse_mass[std::size_t(slot)] > 0,
                 "a node that moves has a finite mass");
    Mat3d k = kNothing;
    add_isotropic(k, 1 / (h2 * double(builder.model.anatomy.inverse_mass[std::size_t(slot)])));
    builder.add_element({&slot, 1}, [&](int, int) { return k; });
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
                              const FineCells& cells, CoarseSpace& space) {
  CoarseOperatorBuilder builder(model, state, levels, cells, space);
  // operator
  builder.find_blocks();
  add_cells(builder);
  add_skin(builder);
  add_loose_edges(builder);
  add_inertia(builder);
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
