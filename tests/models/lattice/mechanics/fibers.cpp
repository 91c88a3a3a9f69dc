// Fibers of exponential cells: stress in rotated directions against the closed form, force and Hessian
// against differences of the energy, fibers of layers.
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/deformed_body.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/build/fiber_lines.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"

namespace turgor::lattice {
namespace {

const Exec kPair(2);
constexpr double kYoung = 8e3, kPoisson = 0.4;

Model fibered_block(const FiberParams& fiber, double stiffening) {
  Params params;
  params.skin.enabled = false;
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.energy = SolidEnergy::kExponential;
  params.tissue.stiffening = stiffening, params.tissue.poisson = kPoisson, params.tissue.fiber = fiber;
  params.solver = {.sweeps = 20, .damping = 0};
  return block_model({.size = {4, 4, 3}, .young = kYoung, .skin_on_top = false}, params);
}

/// Cauchy stress of a stretch λ along the unit vector a and μ across it [Pa], along a and across it:
///   σ = µ c/J (b̄ − ⅓ tr b̄ 1) + κ (J − 1) 1 + 2 Ψ'/J Ī₄ (a aᵀ − ⅓ 1)
struct TransverseStress {
  double along, across;
};
TransverseStress closed_form(const FiberParams& fiber, double stiffening, double stretch, double side) {
  const double mu = kYoung / (2 * (1 + kPoisson)), kappa = kYoung / (3 * (1 - 2 * kPoisson));
  const double j = stretch * side * side, r = std::pow(j, -2.0 / 3);
  const double b1 = r * stretch * stretch, b2 = r * side * side, trace = b1 + 2 * b2;
  const double iso = mu * std::exp(stiffening * (trace - 3)) / j, volume = kappa * (j - 1);
  const double e = std::max(0.0, b1 - 1);
  const double f = 2 * fiber.stiffness * e * std::exp(fiber.stiffening * e * e) * b1 / j;
  return {iso * (b1 - trace / 3) + volume + f * 2 / 3, iso * (b2 - trace / 3) + volume - f / 3};
}

/// The first cell of a block with F = side 1 + (stretch − side) a aᵀ.
class StretchedCell {
 public:
  StretchedCell(const Model& model, Vec3d a, double stretch, double side) : j_(stretch * side * side) {
    Mat3d f;
    for (int c = 0; c < 3; c++) {
      f.column[std::size_t(c)] = a * ((stretch - side) * a[c]);
      f.column[std::size_t(c)][c] += side;
    }
    State state = make_state(model);
    deform(model, state, f);
    const int slot = node_slot(model.anatomy.lattice, {0, 0, 0});
    Real young[kGroup] = {};
    young[0] = model.anatomy.cell_young[std::size_t(slot)];
    law_stresses(node_arrays(model, state), cell_law_view(model, state), node_block(model.anatomy.lattice, 0),
                 young, slot, s_);
    const Vec3 h = model.anatomy.lattice.spacing;
    volume_ = double(h.x) * h.y * h.z;
  }
  /// σ = F S Fᵀ/J along the unit vector `d`, which F stretches by `by`.
  double stress(Vec3d d, double by) const {
    const double entry[3][3] = {{s_.of[0][0], s_.of[3][0], s_.of[4][0]},
                                {s_.of[3][0], s_.of[1][0], s_.of[5][0]},
                                {s_.of[4][0], s_.of[5][0], s_.of[2][0]}};
    double sum = 0;
    for (int i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++) sum += d[i] * entry[i][k] * d[k];
    return sum / volume_ * by * by / j_;
  }

 private:
  LawStresses<kGroup> s_;
  double j_, volume_ = 0;
};

// A block stretched along its fibers, which lie oblique to the lattice, bears the stresses of the closed
// form.
TEST(CellFibers, RotatedBlockMatchesClosedForm) {
  constexpr double kStiffening = 2;
  for (const Vec3d drawn : {Vec3d{1, 0, 0}, Vec3d{0.3, -0.8, 0.52}, Vec3d{-0.5, 0.4, 0.77}}) {
    const FiberParams fiber{.stiffness = 1.5e4, .stiffening = 3, .direction = drawn};
    const Vec3d a = normalized(drawn);
    const Model model = fibered_block(fiber, kStiffening);
    for (const auto& [stretch, side] : {std::array{1.15, 0.95}, {1.3, 0.9}, {0.9, 1.04}}) {
      const Vec3d across = normalized(cross(a, Vec3d{0.2, 0.9, -0.4}));
      const TransverseStress expected = closed_form(fiber, kStiffening, stretch, side);
      const double scale = std::abs(expected.along) + std::abs(expected.across);
      const StretchedCell cell(model, a, stretch, side);
      EXPECT_NEAR(cell.stress(a, stretch), expected.along, 2e-3 * scale) << stretch;
      EXPECT_NEAR(cell.stress(across, side), expected.across, 2e-3 * scale) << stretch;
    }
  }
}

// An image of directions turns the fibers of each cell to the sample nearest to its center: oblique ones have
// the stresses of the closed form. Length and sign of a sample do not matter; zero and far samples leave the
// law's.
TEST(CellFibers, ImageTurnsFibers) {
  constexpr double kStiffening = 2, kStretch = 1.2, kSide = 0.93;
  const FiberParams fiber{.stiffness = 1.5e4, .stiffening = 3, .direction = {1, 0, 0}};
  const Vec3d drawn{0.3, -0.8, 0.52}, a = normalized(drawn);
  Model model = fibered_block(fiber, kStiffening);
  // samples at the centers of the lower two layers of cells; the second has none
  const Grid& grid = model.anatomy.grid;
  VectorVolume image{.grid = grid, .samples = {}};
  image.grid.size = {grid.size.x - 1, grid.size.y - 1, 2};
  image.grid.origin = point_at(grid, Vec3d{0.5, 0.5, 0.5});
  image.samples.assign(sample_count(image.grid), {});
  for (int j = 0; j < image.grid.size.y; j++)
    for (int i = 0; i < image.grid.size.x; i++) image.at(i, j, 0) = Vec3(drawn) * (i % 2 == 0 ? 7.0f : -0.1f);
  const std::vector<Vec3> lines = fiber_lines(image, model);
  ASSERT_FALSE(lines.empty());
  set_fiber_lines(lines, model);
  // directions
  const CellLaws& laws = model.anatomy.cell_laws;
  const auto direction = [&](Int3 cell) {
    const auto slot = std::size_t(node_slot(model.anatomy.lattice, cell));
    return Vec3d{double(laws.fiber_x[slot]), double(laws.fiber_y[slot]), double(laws.fiber_z[slot])};
  };
  EXPECT_NEAR(dot(direction({0, 0, 0}), a), 1, 1e-6);
  EXPECT_NEAR(dot(direction({1, 0, 0}), a), -1, 1e-6);
  EXPECT_EQ(direction({0, 0, 1}), (Vec3d{1, 0, 0}));
  // stress along the fibers
  const double along = StretchedCell(model, a, kStretch, kSide).stress(a, kStretch);
  const TransverseStress expected = closed_form(fiber, kStiffening, kStretch, kSide);
  EXPECT_NEAR(along, expected.along, 2e-3 * std::abs(expected.along));
  // an image beside the body
  image.grid.origin = point_at(grid, Vec3d{50, 0, 0});
  EXPECT_TRUE(fiber_lines(image, model).empty());
}

// Forces on a node are the negative gradient of the body's energy, and the step's Hessian is exact.
TEST(CellFibers, ForceAndHessian) {
  const Model model = fibered_block({.stiffness = 2e4, .stiffening = 4, .direction = {0.6, 0.5, -0.3}}, 3);
  const Lattice& l = model.anatomy.lattice;
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> any(-4e-4f, 4e-4f);
  for (int n = 0; n < 10; n++) {
    State state = make_state(model);
    deform(model, state, {{Vec3d{1.08, 0.02, 0}, Vec3d{0, 1.05, 0.03}, Vec3d{0.01, 0, 0.97}}});
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) {
          const auto s = std::size_t(node_slot(l, {i, j, k}));
          state.motion.u.set(s, state.motion.u[s] + Vec3{any(engine), any(engine), any(engine)});
        }
    const Int3 node{1 + n % 2, 1, 1};
    const auto slot = std::size_t(node_slot(l, node));
    // sum over the eight cells
    NodeSystem system;
    const CellLawView laws = cell_law_view(model, state);
    for (int at = 0; at < kCellCorners; at++) {
      const Int3 cell = node - cell_corner(at);
      Vec3 d[kCellCorners];
      for (int c = 0; c < kCellCorners; c++)
        d[c] = state.motion.u[std::size_t(node_slot(l, cell + cell_corner(c)))] - state.motion.u[slot];
      const int lowest = node_slot(l, cell);
      add_law_cell(system, cell_gradient(d, at, laws.slope), at, laws, lowest,
                   model.anatomy.cell_young[std::size_t(lowest)]);
    }
    const auto energy_at = [&](int axis, Real by) {
      State moved = state;
      Vec3 u = moved.motion.u[slot];
      u[axis] += by;
      moved.motion.u.set(slot, u);
      return energy(kPair, model, moved);
    };
    const double scale = norm(Vec3d(system.f)), diagonal[3] = {system.xx, system.yy, system.zz};
    for (int axis = 0; axis < 3; axis++) {
      EXPECT_NEAR(double(system.f[axis]), -(energy_at(axis, 2e-6f) - energy_at(axis, -2e-6f)) / 4e-6,
                  0.01 * scale);
      const double second =
          (energy_at(axis, 1e-5f) - 2 * energy_at(axis, 0) + energy_at(axis, -1e-5f)) / 1e-10;
      EXPECT_NEAR(diagonal[axis], second, 0.05 * second);
    }
  }
}

// Layers that share a cell average the stiffness of their fibers; a layer keeps its own direction.
TEST(CellFibers, LayersHaveTheirOwn) {
  const std::vector<TissueLayer> layers = {
      {.name = "fat", .thickness = 0.004, .young = 3e3, .poisson = 0.4},
      {.name = "muscle", .young = 9e3, .poisson = 0.4, .fiber = {2e4, 5, {0, 1, 0}}}};
  const LayerMean fat = mean_of_layers(layers, 0, 0.003), both = mean_of_layers(layers, 0.002, 0.006),
                  deep = mean_of_layers(layers, 0.01, 0.014);
  EXPECT_EQ(fat.fiber.stiffness, 0);
  EXPECT_NEAR(both.fiber.stiffness, 1e4, 1e-6);
  EXPECT_NEAR(both.fiber.stiffening, 5, 1e-9);
  EXPECT_EQ(both.fiber.direction, (Vec3d{0, 1, 0}));
  EXPECT_NEAR(deep.fiber.stiffness, 2e4, 1e-6);
}

// A thin layer without shear stiffness lets the layers above slide, by the sum of compliances, and bears
// pressure as before.
TEST(CellFibers, SlidingLayerAddsShearCompliance) {
  const auto layers = [](double slide) {
    return std::vector<TissueLayer>{
        {.name = "skin", .thickness = 0.004, .young = 2e4, .poisson = 0.3},
        {.name = "fascia", .thickness = 0.001, .young = 1e4, .poisson = 0.3, .slide = slide},
        {.name = "muscle", .young = 2e4, .poisson = 0.3}};
  };
  const auto shear = [](double young) { return young / (2 * 1.3); };
  for (const double slide : {1.0, 0.1, 0.02}) {
    const LayerMean cell = mean_of_layers(layers(slide), 0.002, 0.006),
                    before = mean_of_layers(layers(1), 0.002, 0.006);
    EXPECT_NEAR(0.004 / (cell.young / (2 * (1 + cell.poisson))),
                0.003 / shear(2e4) + 0.001 / (slide * shear(1e4)), 1e-9);
    const auto confined = [](const LayerMean& m) {
      return m.young * (1 - m.poisson) / ((1 + m.poisson) * (1 - 2 * m.poisson));
    };
    EXPECT_NEAR(confined(cell), confined(before), 1e-6 * confined(before));
  }
}

}  // namespace
}  // namespace turgor::lattice
