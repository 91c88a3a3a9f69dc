#include "turgor/models/cloth/solver/system.hpp"

#include <Eigen/Sparse>

#include "tests/models/cloth/sheets.hpp"

namespace turgor::cloth {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

struct HalfSpring {
  int a, b;
  double rest, stiffness;
};
std::vector<HalfSpring> half_springs(const Model& model) {
  std::vector<HalfSpring> list;
  const Rows& rows = model.rows;
  for (std::size_t batch = 0; batch < batch_count(rows); batch++)
    for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
      for (int l = 0; l < kLanes; l++) {
        const auto e = std::size_t(s * kLanes + l);
        const int first = rows.first[std::size_t(s)];
        const int b = first >= 0 ? first + l : rows.gathered[std::size_t(-1 - first + l)];
        if (rows.stiffness[e] > 0)
          list.push_back({int(batch) * kLanes + l, b, double(rows.rest[e]), double(rows.stiffness[e])});
      }
  return list;
}

/// Force of the spring on its first end in double precision.
Vec3d spring_force(Vec3d d, const HalfSpring& s) { return d * (s.stiffness * (1 - s.rest / norm(d))); }

/// Block J_ab of the theory: k [ n nᵀ + max(0, 1 − L0/L) (I − n nᵀ) ].
Eigen::Matrix3d block(Vec3d d, const HalfSpring& s) {
  const Eigen::Vector3d n(d.x / norm(d), d.y / norm(d), d.z / norm(d));
  const Eigen::Matrix3d nn = n * n.transpose();
  return s.stiffness * (nn + std::max(0.0, 1 - s.rest / norm(d)) * (Eigen::Matrix3d::Identity() - nn));
}

struct DirectSystem {
  Matrix w;
  Eigen::VectorXd b;
};

/// (M (1 + h α) − s J) Δv = h f + s J v − h α M v; held vertices are eliminated by unit rows.
DirectSystem direct_system(const Model& model, const State& state, const Inputs& inputs, double h) {
  const int n = model.count;
  const double alpha = h * model.params.damping.motion, s = h * h + h * model.params.damping.stretch;
  std::vector<Eigen::Triplet<double>> entries;
  DirectSystem system{Matrix(3 * n, 3 * n), Eigen::VectorXd::Zero(3 * n)};
  const auto is_free = [&](int v) { return state.free_mass[std::size_t(v)] > 0; };
  const auto add = [&](int a, int b, const Eigen::Matrix3d& m) {
    for (int r = 0; r < 3; r++)
      for (int c = 0; c < 3; c++) entries.emplace_back(3 * a + r, 3 * b + c, m(r, c));
  };
  const auto eigen = [](Vec3d a) { return Eigen::Vector3d(a.x, a.y, a.z); };
  for (int v = 0; v < n; v++) {
    const double mass = model.mass[std::size_t(v)];
    add(v, v, Eigen::Matrix3d::Identity() * (is_free(v) ? mass * (1 + alpha) : 1));
    if (!is_free(v)) continue;
    const Vec3d f = inputs.gravity * (h * mass) - Vec3d(state.v[std::size_t(v)]) * (alpha * mass);
    system.b.segment<3>(3 * v) += eigen(f);
  }
  for (const HalfSpring& spring : half_springs(model)) {
    if (!is_free(spring.a)) continue;
    const Vec3d d = Vec3d(state.x[std::size_t(spring.b)]) - Vec3d(state.x[std::size_t(spring.a)]);
    const Vec3d u = Vec3d(state.v[std::size_t(spring.b)]) - Vec3d(state.v[std::size_t(spring.a)]);
    const Eigen::Matrix3d j = block(d, spring);
    add(spring.a, spring.a, s * j);
    add(spring.a, spring.b, -s * j);
    system.b.segment<3>(3 * spring.a) += h * eigen(spring_force(d, spring)) + s * j * eigen(u);
  }
  for (const Hold& hold : state.holds) {
    const auto v = std::size_t(hold.vertex);
    system.b.segment<3>(3 * hold.vertex) = eigen(Vec3d((hold.goal - state.x[v]) / Real(h) - state.v[v]));
  }
  system.w.setFromTriplets(entries.begin(), entries.end());
  return system;
}

Eigen::VectorXd solve(const DirectSystem& system) {
  Eigen::SparseLU<Matrix> lu;
  lu.compute(system.w);
  return lu.solve(system.b);
}

double difference(const Eigen::VectorXd& exact, const Vectors& change) {
  double largest = 0;
  for (int v = 0; v < exact.size() / 3; v++) {
    const Vec3 c = change[std::size_t(v)];
    for (int k = 0; k < 3; k++) largest = std::max(largest, std::abs(exact[3 * v + k] - double(c[k])));
  }
  return largest / exact.cwiseAbs().maxCoeff();
}

/// A crumpled moving sheet of soft cloth; one corner is held and pulled away.
struct Crumpled {
  Model model;
  State state;
  Inputs inputs = in_vacuum();
};
Crumpled crumpled(int n = 12) {
  Params params{.fabric = {.law = Law::kSprings, .warp = 50, .weft = 40, .shear = 10, .bend = 2}};
  params.collision.self = false;
  Crumpled c{.model = must_build(flat_sheet(n), params), .state = {}};
  c.state = make_state(c.model);
  EXPECT_TRUE(hold(c.model, c.state, 0));
  EXPECT_TRUE(move_hold(c.model, c.state, 0, {-0.001f, 0, 0}));
  shake(c.model, c.state.x, 0.004);
  shake(c.model, c.state.v, 0.1, 2);
  return c;
}

// The derivative of a stretched spring matches finite differences.
TEST(ClothSystem, SpringDerivativeMatchesDifferences) {
  const HalfSpring spring{0, 1, 0.01, 30};
  for (const Vec3d d : {Vec3d{0.012, 0, 0}, Vec3d{0.008, 0.009, -0.003}, Vec3d{0.02, -0.01, 0.04}}) {
    const Eigen::Matrix3d j = block(d, spring);
    for (int k = 0; k < 3; k++) {
      Vec3d step;
      step[k] = 1e-7;
      const Vec3d slope = (spring_force(d + step, spring) - spring_force(d - step, spring)) / 2e-7;
      for (int r = 0; r < 3; r++) EXPECT_NEAR(slope[r], j(r, k), 1e-6 * spring.stiffness);
    }
  }
}

// The right-hand side matches a double-precision reference.
TEST(ClothSystem, RightSideMatchesReference) {
  Crumpled c = crumpled();
  const Exec exec(2);
  assemble(exec, c.model, c.state, c.inputs, kFrame);
  const DirectSystem direct = direct_system(c.model, c.state, c.inputs, kFrame);
  double largest = 0;
  for (int v = 0; v < c.model.count; v++)
    for (int k = 0; k < 3; k++)
      largest =
          std::max(largest, std::abs(direct.b[3 * v + k] - double(c.state.system.force[std::size_t(v)][k])));
  EXPECT_LT(largest / direct.b.cwiseAbs().maxCoeff(), 1e-6);
}

// Converged Jacobi sweeps match a direct sparse solve.
TEST(ClothSystem, ConvergedSweepsMatchDirectSolve) {
  for (const double h : {0.001, kFrame}) {
    Crumpled c = crumpled();
    const Exec exec(2);
    assemble(exec, c.model, c.state, c.inputs, h);
    start_change(exec, c.model, c.state, h);
    solve_by_sweeps(exec, c.model, c.state, Method::kJacobi, 60001);
    const Eigen::VectorXd exact = solve(direct_system(c.model, c.state, c.inputs, h));
    EXPECT_LT(difference(exact, c.state.system.change), 2e-5) << h;
  }
}

// Conjugate gradients match a direct sparse solve.
TEST(ClothSystem, ConjugateGradientsMatchDirectSolve) {
  Crumpled c = crumpled();
  const Exec exec(2);
  c.inputs.measure_residual = true;
  assemble(exec, c.model, c.state, c.inputs, kFrame);
  start_change(exec, c.model, c.state, kFrame);
  solve_by_conjugate_gradients(exec, c.model, c.state, {.iterations = 200});
  const Eigen::VectorXd exact = solve(direct_system(c.model, c.state, c.inputs, kFrame));
  EXPECT_LT(difference(exact, c.state.system.change), 2e-5);
  EXPECT_LT(residual(exec, c.model, c.state), 1e-5);
}

double residual_after(State state, const Model& model, Method method, int sweeps) {
  const Exec exec(1);
  if (method == Method::kConjugateGradients)
    solve_by_conjugate_gradients(exec, model, state, {.iterations = sweeps});
  else
    solve_by_sweeps(exec, model, state, method, sweeps);
  return residual(exec, model, state);
}

// On a flag in the wind, Chebyshev sweeps have a smaller residual than Jacobi sweeps.
TEST(ClothSystem, ChebyshevBeatsJacobiOnFlag) {
  Params params{.fabric = {.law = Law::kSprings, .warp = 50, .weft = 50, .shear = 10, .bend = 1}};
  params.collision.self = false;
  const Model model = must_build(flat_sheet(40, 0.02), params);
  State state = make_state(model);
  for (int j = 0; j < 40; j++) EXPECT_TRUE(hold(model, state, j * 40));
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.air.velocity = {6, 2, 0};
  const Exec exec(1);
  for (int frame = 0; frame < 60; frame++) step(exec, model, state, inputs, kFrame);
  inputs.measure_residual = true;
  assemble(exec, model, state, inputs, kFrame);
  start_change(exec, model, state, kFrame);
  for (const int sweeps : {15, 31, 63})
    EXPECT_LT(residual_after(state, model, Method::kChebyshev, sweeps),
              0.8 * residual_after(state, model, Method::kJacobi, sweeps))
        << sweeps;
  EXPECT_LT(residual_after(state, model, Method::kConjugateGradients, 127),
            residual_after(state, model, Method::kChebyshev, 127));
}

// A sheet in free fall gains g h of speed after one sweep.
TEST(ClothSystem, FreeFallNeedsOneSweep) {
  Params params;
  params.damping = {0, 0};
  const Model model = must_build(flat_sheet(10), params);
  State state = make_state(model);
  const Exec exec(1);
  assemble(exec, model, state, in_vacuum(), kFrame);
  start_change(exec, model, state, kFrame);
  solve_by_sweeps(exec, model, state, Method::kJacobi, 1);
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    EXPECT_NEAR(state.system.change.z[v], -9.81 * kFrame, 1e-5);
}

}  // namespace
}  // namespace turgor::cloth
