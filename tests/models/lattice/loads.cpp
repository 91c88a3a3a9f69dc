// Loads on nodes and the weight of a body: momentum, stretched bars, sagging bars, free fall.
#include <Eigen/SparseCholesky>
#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

constexpr double kFrame = 1.0 / 60;  // [s]

/// Mass of a node: a cell of tissue at 0 HU [kg].
double node_mass(double step) { return 1000 * step * step * step; }

// A loaded free node accelerates by its force over its mass.
TEST(LatticeLoads, LoadedNodeAcceleratesByForceOverMass) {
  for (const Method method : {Method::kPbd, Method::kVbd}) {
    Params params;
    params.skin.enabled = false;
    params.solver = {.method = method, .damping = 0};
    const Int3 size{9, 8, 7};
    const Model model =
        block_model({.size = size, .young = 1e-6, .skin_on_top = false}, params);  // nearly no stiffness
    State state = make_state(model);
    const int slot = node_slot(model.anatomy.lattice, 4, 3, 3);
    for (std::size_t edge = 0; edge < state.cuts.cut.size(); edge++)
      state.cuts.cut[edge] = 0x7f;  // isolates every node
    std::fill(state.cuts.row_cut.begin(), state.cuts.row_cut.end(), std::uint8_t(1));
    const Vec3 force{1e-5f, -2e-5f, 4e-5f};
    const NodeLoad loads[] = {{slot, force * 0.75f}, {slot, force * 0.25f}};  // loads on one node are summed
    step(Exec(1), model, state, {.loads = loads}, kFrame);
    const Vec3d expected = Vec3d(force) * (kFrame / node_mass(0.004));
    const Vec3d found(state.motion.v[std::size_t(slot)]);
    EXPECT_LT(norm(found - expected), 1e-5 * norm(expected)) << "m/s, method " << int(method);
    EXPECT_EQ(norm(state.motion.v[std::size_t(node_slot(model.anatomy.lattice, 5, 3, 3))]), 0)
        << "its neighbor";
  }
}

// Loads change the momentum by their sum; balanced loads do not change it.
TEST(LatticeLoads, LoadsChangeMomentumByTheirSum) {
  Params params;
  params.skin.enabled = false;
  params.tissue.volume = 1;
  params.solver = {.sweeps = 200, .damping = 0};  // VBD conserves momentum when it has converged
  const Int3 size{9, 8, 7};
  const Model model = block_model({.size = size, .young = 20, .skin_on_top = false},
                                  params);  // soft, so that sweeps reach the whole body soon
  const auto slot = [&](Int3 p) { return node_slot(model.anatomy.lattice, p); };
  const std::vector<NodeLoad> balanced = {{slot({0, 0, 0}), {1e-5f, 2e-5f, 0}},
                                          {slot({8, 7, 6}), {1e-5f, -5e-5f, 0}},
                                          {slot({4, 4, 3}), {-2e-5f, 3e-5f, 0}}};
  std::vector<NodeLoad> more = balanced;
  more.push_back({slot({2, 2, 2}), {0, 0, 3e-5f}});
  for (const auto& [loads, sum] : {std::pair{balanced, Vec3d{}}, std::pair{more, Vec3d{0, 0, 3e-5}}}) {
    State state = make_state(model);
    for (int n = 0; n < 5; n++) step(Exec(1), model, state, {.loads = loads}, kFrame);
    Vec3d momentum;
    for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
      if (model.anatomy.inverse_mass[s] > 0)
        momentum += Vec3d(state.motion.v[s]) / double(model.anatomy.inverse_mass[s]);
    EXPECT_LT(norm(momentum - sum * (5 * kFrame)), 0.01 * 3e-5 * 5 * kFrame) << momentum.z << " kg m/s";
  }
}

// A clamped bar under an end load stretches by Hooke's law.
TEST(LatticeLoads, LoadedBarFollowsHooke) {
  const Int3 size{61, 9, 9};
  Params params;
  params.skin.enabled = false;
  params.solver = {.sweeps = 40, .damping = 8};
  const Block block{
      .size = size, .young = 1e4, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }};
  const Model model = block_model(block, params);
  const double area = size.y * size.z * 0.004 * 0.004, length = (size.x - 1) * 0.004,
               force = 1e4 * area * 0.01;
  std::vector<NodeLoad> loads;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      loads.push_back(
          {node_slot(model.anatomy.lattice, size.x - 1, j, k), {Real(force / (size.y * size.z)), 0, 0}});
  State state = make_state(model);
  for (int n = 0; n < 300; n++) step(Exec(2), model, state, {.loads = loads}, kFrame);
  double stretch = 0;
  for (const NodeLoad& load : loads)
    stretch += double(state.motion.u[std::size_t(load.slot)].x) / double(loads.size());
  EXPECT_NEAR(stretch, force * length / (1e4 * area), 0.1 * 0.01 * length) << "m, F L / (E A)";
  const Residual residual = measure_residual(Exec(1), model, state, {.loads = loads}, kFrame);
  EXPECT_LT(state.motion.v[std::size_t(loads[0].slot)].x, 1e-3)
      << "at rest; residual " << residual.largest << " N";
}

/// A bar along x, fixed at its left end.
Model cantilever(int sweeps, Int3 size) {
  Params params;
  params.skin.enabled = false;
  params.solver = {.sweeps = sweeps, .damping = 8};
  return block_model(
      {.size = size, .young = 2e5, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }},
      params);
}

/// Mean displacement of the right end along an axis after `seconds` [m].
double settled_end(const Model& model, const Inputs& inputs, double rate, double seconds, int axis) {
  State state = make_state(model);
  for (int n = 0; n < seconds * rate; n++) step(Exec(2), model, state, inputs, 1 / rate);
  const Int3 size = model.anatomy.lattice.size;
  double sum = 0;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      sum += double(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, size.x - 1, j, k))][axis]);
  return sum / (size.y * size.z);
}

/// The same by the stiffness matrix of the springs for small displacements, solved directly.
double linear_end(const Model& model, Vec3d gravity, int axis) {
  const Lattice& l = model.anatomy.lattice;
  const auto index = [&](Int3 p) { return 3 * (p.x + l.size.x * (p.y + l.size.y * p.z)); };
  std::vector<Eigen::Triplet<double>> entries;
  const int count = 3 * l.size.x * l.size.y * l.size.z;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(count);
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 a{i, j, k};
        const auto slot = std::size_t(node_slot(l, a));
        const double w = double(model.anatomy.inverse_mass[slot]),
                     root = double(model.springs.root_stiffness[slot]);
        for (int r = 0; r < 3; r++) {
          weight[index(a) + r] = w > 0 ? gravity[r] / w : 0;
          if (w == 0) entries.emplace_back(index(a) + r, index(a) + r, 1e12);  // fixed
        }
        for (std::size_t f = 0; f < kFamilyCount; f++) {
          const Int3 b = a + kFamilies[f];
          if (!contains(l, b)) continue;
          const Vec3d n = normalized(Vec3d(rest_position(l, b) - rest_position(l, a)));
          const double stiffness = double(model.springs.scale[f]) * root *
                                   double(model.springs.root_stiffness[std::size_t(node_slot(l, b))]);
          for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
              for (const auto& [p, q, sign] : {std::tuple{a, a, 1}, {b, b, 1}, {a, b, -1}, {b, a, -1}})
                entries.emplace_back(index(p) + r, index(q) + c, sign * stiffness * n[r] * n[c]);
        }
      }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(weight);
  double sum = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++) sum += u[index({l.size.x - 1, j, k}) + axis];
  return sum / (l.size.y * l.size.z);
}

// A cantilever sags by its weight for any number of sweeps, frame rate and direction.
TEST(LatticeLoads, BarSagIndependentOfSolver) {
  struct Case {
    int axis, sweeps;
    double rate, seconds;
  };
  for (const auto& [axis, sweeps, rate, seconds] :
       {Case{2, 5, 30, 25}, {2, 5, 60, 8}, {2, 20, 60, 3}, {2, 5, 120, 4}, {1, 5, 60, 8}, {0, 5, 60, 4}}) {
    const Model model = cantilever(sweeps, {15, 5, 6});
    Vec3d gravity;
    gravity[axis] = -9.81;
    const double expected = linear_end(model, gravity, axis);
    EXPECT_NEAR(settled_end(model, {.gravity = gravity}, rate, seconds, axis), expected,
                0.03 * std::abs(expected))
        << "m along axis " << axis << ", " << sweeps << " sweeps at " << rate << " Hz";
  }
}

// Gravity bends a bar as equal loads on its nodes do.
TEST(LatticeLoads, GravityEqualsNodalLoads) {
  const Model model = cantilever(5, {25, 6, 6});
  std::vector<NodeLoad> loads;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++)
    if (const Real w = model.anatomy.inverse_mass[s]; w > 0)
      loads.push_back({int(s), {0, 0, Real(-9.81) / w}});
  const double weight = settled_end(model, {.gravity = {0, 0, -9.81}}, 60, 8, 2);
  EXPECT_LT(weight, -5e-3) << "m: a large displacement";
  EXPECT_NEAR(weight, settled_end(model, {.loads = loads}, 60, 8, 2), 0.001 * std::abs(weight));
}

// A free body is in free fall for any number of sweeps.
TEST(LatticeLoads, FreeBodyFallsFreely) {
  for (const int sweeps : {1, 5, 40}) {
    Params params;
    params.skin.enabled = false;
    params.solver = {.sweeps = sweeps, .damping = 0};
    const Model model = block_model({.size = {9, 8, 7}, .young = 2e5, .skin_on_top = false}, params);
    State state = make_state(model);
    for (int n = 0; n < 30; n++) step(Exec(1), model, state, {.gravity = {3, 0, -9.81}}, kFrame);
    const Vec3 v = state.motion.v[std::size_t(node_slot(model.anatomy.lattice, 4, 3, 3))];
    EXPECT_NEAR(v.z, -9.81 * 30 * kFrame, 1e-3) << "m/s, " << sweeps << " sweeps";
    EXPECT_NEAR(v.x, 3 * 30 * kFrame, 1e-3);
  }
}

}  // namespace
}  // namespace turgor::lattice
