#include "turgor/models/sfem/rotation.hpp"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"

namespace turgor::sfem {
namespace {

constexpr double kLength = 0.1, kSide = 0.02;
constexpr auto kLinear = std::span(kCases).first<4>();

Model beam(Case kind, double poisson = 0.3) {
  SolidMesh mesh = hex_block({kLength, kSide, kSide}, {10, 2, 2});
  mesh = with_corners(mesh, kind.corners);
  Body body = block_of(std::move(mesh), {1e5, poisson}, [](Vec3d x) { return x.x < 1e-9; });
  Model model = build(Exec(1), std::move(body), {.formulation = kind.formulation}).value();
  EXPECT_TRUE(factorize(Exec(1), model));
  return model;
}

/// A force distributed over the vertices at a beam's end.
std::vector<Vec3d> end_force(const SolidMesh& mesh, Vec3d total) {
  std::vector<Vec3d> forces(mesh.vertices.size());
  for (std::size_t v = 0; v < forces.size(); v++)
    if (mesh.vertices[v].x > kLength - 1e-9) forces[v] = total / 9;
  return forces;
}

double moved_volume(SolidMesh mesh, const std::vector<Vec3d>& displacement) {
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) mesh.vertices[v] += displacement[v];
  return volume(mesh);
}

Eigen::Matrix3d matrix(const Mat3d& m) {
  Eigen::Matrix3d result;
  for (int c = 0; c < 3; c++)
    for (int r = 0; r < 3; r++) result(r, c) = m.column[c][r];
  return result;
}

// The nearest rotation is that of the polar decomposition.
TEST(SfemRotation, NearestRotationIsPolar) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (int i = 0; i < 200; i++) {
    Mat3d f;
    for (Vec3d& column : f.column) column = {entry(random), entry(random), entry(random)};
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix(f), Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
    flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    // For an inverted matrix with two equal smallest stretches, the rotation is not unique.
    if (flip(2, 2) < 0 && svd.singularValues()[1] < 1.5 * svd.singularValues()[2]) continue;
    const Eigen::Matrix3d expected = svd.matrixU() * flip * svd.matrixV().transpose();
    EXPECT_LT((matrix(nearest_rotation(f, {})) - expected).norm(), 1e-6) << i;
  }
}

// Elements that only rotate have no force.
TEST(SfemRotation, RotatedElementsHaveNoForce) {
  for (const Case kind : kCases) {
    const Model model = beam(kind);
    const Corotation corotation = make_corotation(Exec(1), model);
    // The clamp would have to rotate too, so only regions away from the clamp are compared.
    const double angle = 2;
    RotationState state = make_rotation_state(model);
    for (std::size_t row = 0; row < model.vertex.size(); row++) {
      const Vec3d x = model.body.mesh.vertices[std::size_t(model.vertex[row])];
      state.u[3 * row] = x.x * std::cos(angle) - x.y * std::sin(angle) - x.x;
      state.u[3 * row + 1] = x.x * std::sin(angle) + x.y * std::cos(angle) - x.y;
    }
    std::vector<double> forces(state.u.size());
    update_rotations(Exec(1), model, corotation, state.u, state.rotation);
    element_forces(Exec(1), model, corotation, state.rotation, state.u, forces);
    for (std::size_t row = 0; row < model.vertex.size(); row++)
      if (model.body.mesh.vertices[std::size_t(model.vertex[row])].x > 0.061) {
        for (std::size_t i = 0; i < 3; i++) EXPECT_NEAR(forces[3 * row + i], 0, 1e-9);
      }
  }
}

// Small displacements have the forces of the linear model.
TEST(SfemRotation, SmallDisplacementsAreLinear) {
  for (const Case kind : kLinear) {
    const Model model = beam(kind);
    const Corotation corotation = make_corotation(Exec(1), model);
    RotationState state = make_rotation_state(model);
    for (std::size_t i = 0; i < state.u.size(); i++) state.u[i] = 1e-12 * std::sin(double(i * i % 97));
    std::vector<double> forces(state.u.size()), back;
    update_rotations(Exec(1), model, corotation, state.u, state.rotation);
    element_forces(Exec(1), model, corotation, state.rotation, state.u, forces);
    back = forces;
    solve(*model.factor, back);
    double difference = 0;
    for (std::size_t i = 0; i < back.size(); i++)
      difference = std::max(difference, std::abs(back[i] - state.u[i]));
    EXPECT_LT(difference, 1e-12 * 1e-7) << kind.corners;
  }
}

/// Reference equilibrium: Newton's method with dense matrices and rotations from singular values, with the
/// force applied in small steps.
std::vector<Vec3d> newton_solution(const Model& model, const std::vector<Vec3d>& forces, int load_steps) {
  const SolidMesh& mesh = model.body.mesh;
  const auto corners = Eigen::Index(mesh.corners), n = Eigen::Index(mesh.vertices.size());
  const std::vector<double> matrices = element_matrices(
      Exec(1), mesh, model.body.materials, element_materials(model.body), model.params.formulation);
  std::vector<Vec3d> u(mesh.vertices.size());
  for (int load = 1; load <= load_steps; load++)
    for (int iteration = 0; iteration < 25; iteration++) {
      Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(3 * n, 3 * n);
      Eigen::VectorXd missing(3 * n);
      for (Eigen::Index i = 0; i < 3 * n; i++)
        missing[i] = forces[std::size_t(i / 3)][int(i % 3)] * load / load_steps;
      for (std::size_t e = 0; e < element_count(mesh); e++) {
        const auto vertices = element(mesh, e);
        Eigen::MatrixXd rest(3, corners), moved(3, corners);
        for (Eigen::Index c = 0; c < corners; c++) {
          const auto v = std::size_t(vertices[std::size_t(c)]);
          const Vec3d x = mesh.vertices[v], y = x + u[v];
          rest.col(c) << x.x, x.y, x.z;
          moved.col(c) << y.x, y.y, y.z;
        }
        // Best linear map from rest to moved corners: exact for tetrahedra and, for the boxes of these tests,
        // the map at the center of hexahedra.
        const Eigen::MatrixXd a = rest.colwise() - rest.rowwise().mean(),
                              b = moved.colwise() - moved.rowwise().mean();
        const Eigen::Matrix3d f = b * a.transpose() * (a * a.transpose()).inverse();
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const Eigen::Matrix3d r = svd.matrixU() * svd.matrixV().transpose();
        const Eigen::MatrixXd local = r.transpose() * moved - rest;
        const Eigen::Index size = 3 * corners;
        const Eigen::Map<const Eigen::MatrixXd> k(&matrices[e * std::size_t(size * size)], size, size);
        Eigen::MatrixXd rotation = Eigen::MatrixXd::Zero(size, size);
        for (Eigen::Index c = 0; c < corners; c++) rotation.block<3, 3>(3 * c, 3 * c) = r;
        const Eigen::MatrixXd rotated = rotation * k * rotation.transpose();
        const Eigen::VectorXd force = rotation * (k * local.reshaped());
        for (Eigen::Index p = 0; p < size; p++) {
          const Eigen::Index row = 3 * vertices[std::size_t(p / 3)] + p % 3;
          missing[row] -= force[p];
          for (Eigen::Index q = 0; q < size; q++)
            tangent(row, 3 * vertices[std::size_t(q / 3)] + q % 3) += rotated(p, q);
        }
      }
      std::vector<Eigen::Index> free;
      for (Eigen::Index i = 0; i < 3 * n; i++)
        if (!model.body.fixed[std::size_t(i / 3)]) free.push_back(i);
      const Eigen::VectorXd step = tangent(free, free).ldlt().solve(missing(free));
      for (std::size_t i = 0; i < free.size(); i++)
        u[std::size_t(free[i] / 3)][int(free[i] % 3)] += step[Eigen::Index(i)];
      if (step.norm() < 1e-10 * kLength) break;
    }
  return u;
}

// A strongly bent beam matches an independent Newton solution.
TEST(SfemRotation, BentBeamMatchesNewtonSolution) {
  for (const Case kind :
       {Case{4, Formulation::kStandard}, Case{8, Formulation::kStandard}, Case{8, Formulation::kAveraged}}) {
    const Model model = beam(kind);
    const Corotation corotation = make_corotation(Exec(1), model, 0);
    const std::vector<Vec3d> forces = end_force(model.body.mesh, {0, 0, -0.3});
    RotationState state = make_rotation_state(model);
    const RotationReport report = correct_rotations(Exec(2), model, corotation, forces,
                                                    {.most_solves = 2000, .tolerance = 1e-8}, state);
    EXPECT_TRUE(report.converged) << report.solves << " solves, residual " << report.residual;
    const std::vector<Vec3d> expected = newton_solution(model, forces, 10);
    double difference = 0, largest = 0;
    for (std::size_t v = 0; v < expected.size(); v++) {
      difference = std::max(difference, norm(state.displacement[v] - expected[v]));
      largest = std::max(largest, norm(expected[v]));
    }
    EXPECT_GT(largest, 0.35 * kLength);
    EXPECT_LT(difference, 1e-5 * largest) << kind.corners << " corners, " << report.solves << " solves";
  }
}

// Rotations by regions bend a beam as rotations by elements, within 3 %.
TEST(SfemRotation, RegionsMatchSingleElements) {
  for (const Case kind : kLinear) {
    const Model model = beam(kind);
    const std::vector<Vec3d> forces = end_force(model.body.mesh, {0, 0, -0.2});
    RotationState single = make_rotation_state(model), region = single;
    const RotationParams exact{.most_solves = 2000, .tolerance = 1e-6};
    ASSERT_TRUE(correct_rotations(Exec(2), model, make_corotation(Exec(1), model, 0), forces, exact, single)
                    .converged);
    const RotationReport report =
        correct_rotations(Exec(2), model, make_corotation(Exec(1), model), forces, exact, region);
    ASSERT_TRUE(report.converged) << report.residual;
    double difference = 0, largest = 0;
    for (std::size_t v = 0; v < single.displacement.size(); v++) {
      difference = std::max(difference, norm(single.displacement[v] - region.displacement[v]));
      largest = std::max(largest, norm(single.displacement[v]));
    }
    std::printf("%d corners: %.1f %% of a deflection of %.0f mm\n", kind.corners, 100 * difference / largest,
                1e3 * largest);
    EXPECT_GT(largest, 0.25 * kLength);
    EXPECT_LT(difference, 0.03 * largest) << kind.corners << " corners";
  }
}

// A bent beam swells in the linear model and keeps its volume with corotation.
TEST(SfemRotation, CorotationKeepsVolumeOfBentBeam) {
  for (const Case kind : kLinear) {
    const Model model = beam(kind);
    const Corotation corotation = make_corotation(Exec(1), model);
    RotationState state = make_rotation_state(model);
    const RotationReport report =
        correct_rotations(Exec(2), model, corotation, end_force(model.body.mesh, {0, 0, -0.2}),
                          {.most_solves = 2000, .tolerance = 1e-5}, state);
    ASSERT_TRUE(report.converged) << report.residual;
    std::vector<Vec3d> linear = state.displacement;
    for (std::size_t v = 0; v < linear.size(); v++) linear[v] -= state.free[v];
    const double rest = volume(model.body.mesh);
    EXPECT_GT(moved_volume(model.body.mesh, linear), 1.05 * rest) << kind.corners;
    EXPECT_NEAR(moved_volume(model.body.mesh, state.displacement), rest, 0.02 * rest) << kind.corners;
  }
}

// Calls with few solves continue from the last state until convergence.
TEST(SfemRotation, ShortCallsContinue) {
  const Model model = beam(kCases[0]);
  const Corotation corotation = make_corotation(Exec(1), model);
  const std::vector<Vec3d> forces = end_force(model.body.mesh, {0, 0, -0.3});
  RotationState state = make_rotation_state(model);
  RotationReport report;
  int calls = 0;
  for (; calls < 100 && !report.converged; calls++) {
    report = correct_rotations(Exec(1), model, corotation, forces, {.most_solves = 12}, state);
    EXPECT_LE(report.solves, 12);
  }
  EXPECT_GT(calls, 1);
  EXPECT_TRUE(report.converged) << report.residual;
  const RotationReport again = correct_rotations(Exec(1), model, corotation, forces, {}, state);
  EXPECT_TRUE(again.converged);
  EXPECT_EQ(again.solves, 2);
}

// A failure to converge is reported, and the state stays finite.
TEST(SfemRotation, ReportsNonConvergence) {
  const Model model = beam(kCases[3]);
  const Corotation corotation = make_corotation(Exec(1), model);
  const std::vector<Vec3d> forces =
      end_force(model.body.mesh, {-50, 0, -20});  // compressed to nearly zero length
  RotationState state = make_rotation_state(model);
  const RotationReport report =
      correct_rotations(Exec(1), model, corotation, forces, {.most_solves = 200}, state);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.residual, 1e-3);
  EXPECT_LE(report.residual, 1);
  for (const Vec3d u : state.displacement) EXPECT_TRUE(std::isfinite(norm(u)));
}

// Without forces, a body returns to rest from any state.
TEST(SfemRotation, ReturnsToRestWithoutForces) {
  const Model model = beam(kCases[3]);
  const Corotation corotation = make_corotation(Exec(1), model);
  RotationState state = make_rotation_state(model);
  (void)correct_rotations(Exec(1), model, corotation, end_force(model.body.mesh, {-50, 0, -20}), {}, state);
  const std::vector<Vec3d> none(model.body.mesh.vertices.size());
  const RotationReport report = correct_rotations(Exec(1), model, corotation, none, {}, state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(state.displacement, none);
  EXPECT_EQ(state.free, none);
}

// Without forces, nothing moves.
TEST(SfemRotation, ZeroForcesGiveZeroDisplacement) {
  const Model model = beam(kCases[0]);
  RotationState state = make_rotation_state(model);
  const RotationReport report =
      correct_rotations(Exec(1), model, make_corotation(Exec(1), model),
                        std::vector<Vec3d>(model.body.mesh.vertices.size()), {}, state);
  EXPECT_TRUE(report.converged);
  for (const Vec3d u : state.free) EXPECT_EQ(u, Vec3d());
}

// One, two and eight threads give the same bits.
TEST(SfemRotation, EqualBitsOnAnyThreads) {
  const Model model = beam(kCases[1]);
  const Corotation corotation = make_corotation(Exec(1), model);
  const std::vector<Vec3d> forces = end_force(model.body.mesh, {0, 0.05, -0.1});
  RotationState one = make_rotation_state(model);
  correct_rotations(Exec(1), model, corotation, forces, {.most_solves = 40}, one);
  for (const int threads : {2, 8}) {
    RotationState many = make_rotation_state(model);
    correct_rotations(Exec(threads), model, corotation, forces, {.most_solves = 40}, many);
    EXPECT_EQ(one.u, many.u);
  }
}

// A pressed block converges within 12 solves.
TEST(SfemRotation, PressedBlockConvergesInFewSolves) {
  SolidMesh mesh = tetrahedralize(hex_block({0.1, 0.1, 0.1}, {10, 10, 10}));
  Model model =
      build(Exec(1), block_of(std::move(mesh), {3e3, 0.45}, [](Vec3d x) { return x.z < 1e-9; }), {}).value();
  ASSERT_TRUE(factorize(Exec(2), model));
  std::vector<Vec3d> forces(model.body.mesh.vertices.size());
  for (std::size_t v = 0; v < forces.size(); v++) {
    const Vec3d x = model.body.mesh.vertices[v];
    if (x.z > 0.0999 && std::hypot(x.x - 0.05, x.y - 0.05) < 0.0201) forces[v] = {0, 0, -1.0 / 13};
  }
  RotationState state = make_rotation_state(model);
  const RotationReport report = correct_rotations(Exec(2), model, make_corotation(Exec(2), model), forces,
                                                  {.most_solves = 12, .tolerance = 1e-3}, state);
  EXPECT_TRUE(report.converged) << report.residual;
  const int tip = vertex_at(model.body.mesh, {0.05, 0.05, 0.1});
  EXPECT_LT(state.displacement[std::size_t(tip)].z, -0.0075);
}

}  // namespace
}  // namespace turgor::sfem
