// The coarse operator against elements that are summed one by one.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/coarse/block_moments.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"

namespace turgor::lattice {
namespace {

constexpr double kStepTime = 1.0 / 60;

/// A block without skin and blades, with moduli that differ from cell to cell, and fixed nodes at one side
/// and inside.
Model uneven_block(bool with_skin = false) {
  Params params = solid_params(5, 4, 0);
  params.tissue.poisson = 0.4;
  Block block{.size = {19, 14, 11}, .spacing = 0.004, .young = 5e3, .skin_on_top = with_skin};
  block.is_fixed = [](Int3 p) { return p.x == 0 || (p.x > 8 && p.x < 11 && p.y == 7 && p.z > 3); };
  BodyNodes nodes = block_nodes(block);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> young(1e3, 9e3);
  for (float& e : nodes.young) e = young(random);
  params.skin.enabled = with_skin;
  return assemble(Exec(1), nodes, nullptr, params).value();
}

using Field = std::vector<Vec3d>;  // by slot [m]

/// Displacements of the nodes for values of the unknowns.
Field prolongated(const Model& model, const CoarseSpace& space, const std::vector<double>& x) {
  Field u(model.anatomy.inverse_mass.size());
  const auto add_row = [&](int row, double weight, Vec3d& sum) {
    for (int t = space.row_begin[std::size_t(row)]; t < space.row_begin[std::size_t(row) + 1]; t++) {
      const auto at = 3 * std::size_t(space.terms[std::size_t(t)].unknown);
      sum += Vec3d{x[at], x[at + 1], x[at + 2]} * (weight * double(space.terms[std::size_t(t)].weight));
    }
  };
  for (std::size_t slot = 0; slot < u.size(); slot++) {
    const int source = space.interpolation[slot];
    if (source <= -2) add_row(-2 - source, 1, u[slot]);
    if (source < 0) continue;
    const CoarseBlock& block = space.blocks[std::size_t(source)];
    const auto weights = corner_weights(block, slot_node(model.anatomy.lattice, int(slot)));
    for (std::size_t c = 0; c < 8; c++) add_row(block.corner[c], double(weights[c]), u[slot]);
  }
  return u;
}

/// Displacement gradient at the center of a cell with lowest node `low`, and hourglass displacements.
struct CellStrain {
  std::array<Vec3d, 3> gradient{};  // by columns [1]
  std::array<Vec3d, 8> hourglass{};
};
CellStrain strain_of(const Model& model, const Field& u, Int3 low) {
  CellStrain s;
  const Vec3d h(model.anatomy.lattice.spacing);
  Vec3d mean;
  std::array<Vec3d, 8> d;
  for (int c = 0; c < 8; c++) {
    d[std::size_t(c)] = u[std::size_t(node_slot(model.anatomy.lattice, low + cell_corner(c)))];
    mean += d[std::size_t(c)] / 8;
    for (int axis = 0; axis < 3; axis++)
      s.gradient[std::size_t(axis)] += d[std::size_t(c)] * ((cell_corner(c)[axis] ? 0.25 : -0.25) / h[axis]);
  }
  for (int c = 0; c < 8; c++) {
    Vec3d affine = mean;
    for (int axis = 0; axis < 3; axis++)
      affine += s.gradient[std::size_t(axis)] * (h[axis] * (cell_corner(c)[axis] ? 0.5 : -0.5));
    s.hourglass[std::size_t(c)] = d[std::size_t(c)] - affine;
  }
  return s;
}

/// Virtual work of linear elasticity and inertia: `a` displaced by `b` [J].
double work(const Model& model, const Field& a, const Field& b) {
  const Lattice& l = model.anatomy.lattice;
  const double nu = model.params.tissue.poisson, mu = 0.5 / (1 + nu), lambda = nu / ((1 + nu) * (1 - 2 * nu));
  const double volume = double(l.spacing.x) * double(l.spacing.y) * double(l.spacing.z);
  const double hourglass = double(solid_law(l.spacing, nu).hourglass);
  double sum = 0;
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int i = 0; i + 1 < l.size.x; i++) {
        const double young = double(model.anatomy.cell_young[std::size_t(node_slot(l, i, j, k))]);
        if (!(young > 0)) continue;
        const CellStrain p = strain_of(model, a, {i, j, k}), q = strain_of(model, b, {i, j, k});
        double shear = 0, trace_p = 0, trace_q = 0, modes = 0;
        for (std::size_t m = 0; m < 3; m++) {
          trace_p += p.gradient[m][int(m)], trace_q += q.gradient[m][int(m)];
          for (std::size_t n = 0; n < 3; n++)
            shear += (p.gradient[m][int(n)] + p.gradient[n][int(m)]) * q.gradient[m][int(n)];
        }
        for (std::size_t c = 0; c < 8; c++) modes += dot(p.hourglass[c], q.hourglass[c]);
        sum += young * (volume * (mu * shear + lambda * trace_p * trace_q) + hourglass * modes);
      }
  for (std::size_t s = 0; s < a.size(); s++)
    if (model.anatomy.inverse_mass[s] > 0)
      sum += dot(a[s], b[s]) / (double(model.anatomy.inverse_mass[s]) * kStepTime * kStepTime);
  return sum;
}

// The solution of the coarse operator does the virtual work of the forces along any correction. The elements
// are summed one by one in the whole body.
TEST(CoarseOperator, SolutionBalancesSumOfElements) {
  const Model model = uneven_block();
  const State state = make_state(model);
  const auto space = make_coarse_space(model, state, kStepTime);
  ASSERT_GT(space->unknowns, 50);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto any = [&] {
    std::vector<double> values(3 * std::size_t(space->unknowns));
    for (double& v : values) v = number(random);
    return values;
  };
  const std::vector<double> forces = any();
  const Field solution = prolongated(model, *space, space->factor.solve(forces));
  for (int n = 0; n < 20; n++) {
    const std::vector<double> y = any();
    double expected = 0, size = 0;
    for (std::size_t i = 0; i < y.size(); i++) expected += y[i] * forces[i], size += y[i] * y[i];
    EXPECT_NEAR(work(model, solution, prolongated(model, *space, y)), expected, 2e-4 * std::sqrt(size));
  }
}

// Every block adds its elements in the same order, so that threads do not change a bit.
TEST(CoarseOperator, ThreadsGiveSameBits) {
  const Model model = uneven_block(true);
  const State state = make_state(model);
  const auto one = make_coarse_space(model, state, kStepTime);
  for (const int threads : {2, 8}) {
    const auto more = make_coarse_space(model, state, kStepTime, Exec(threads));
    EXPECT_EQ(one->factor.row, more->factor.row);
    EXPECT_EQ(one->factor.value, more->factor.value);
    EXPECT_EQ(one->factor.inverse_diagonal, more->factor.inverse_diagonal);
  }
}

// Moments give the same matrix as cells that are projected one by one, at positions that are no samples.
TEST(CoarseOperator, MomentsMatchProjectedCells) {
  const Vec3 spacing{0.004f, 0.005f, 0.003f};
  for (const int size : {2, 4, 8}) {
    const CoarseBlock block{.low = {3, 1, 2}, .size = size, .leaf = {}, .corner = {}};
    const std::array<Mat3d, 64> k = cell_stiffness(spacing, 0.45);
    BlockMatrix expected{}, found{};
    BlockMoments moments;
    double young = 1;
    for (int c = 0; c < size * size * size; c += 3) {
      const Int3 at{c % size, c / size % size, c / size / size};
      NodeWeights weights{};
      for (int n = 0; n < 8; n++) {
        const auto w = corner_weights(block, block.low + at + cell_corner(n));
        std::copy(w.begin(), w.end(), weights[std::size_t(n)].begin());
      }
      const auto of_pair = [&](int p, int q) -> const Mat3d& { return k[std::size_t(8 * p + q)]; };
      add_projected(8, weights, of_pair, young, expected);
      add_moments(Vec3d(at) * (1.0 / size), young, moments.stiffness);
      young = young * 1.7 > 10 ? 0.3 : young * 1.7;
    }
    add_expanded(moments, block_basis(size, spacing, 0.45), found);
    double largest = 0;
    for (const double e : expected) largest = std::max(largest, std::abs(e));
    for (std::size_t n = 0; n < found.size(); n++)
      EXPECT_NEAR(found[n], expected[n], 1e-12 * largest) << "entry " << n << ", size " << size;
  }
}

}  // namespace
}  // namespace turgor::lattice
