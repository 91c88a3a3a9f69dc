// Contact of tools with sfem bodies against an independent program of finite elements: linear tetrahedra
// assembled from the gradients of their corners and solved by Eigen, on an irregular mesh with a stiff
// nodule. The program shares no code with the model except the mesh, which this file makes too.
#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include <gtest/gtest.h>

#include "turgor/contact/touch.hpp"

namespace turgor::contact {
namespace {

constexpr sfem::Material kFlesh{4e3, 0.4}, kNodule{6e4, 0.3};
const Vec3d kMiddle{0.034, 0.03, 0.028};  // of the nodule [m]
constexpr double kNoduleRadius = 0.009;   // [m]

using Matrix = Eigen::SparseMatrix<double>;
Eigen::Vector3d eigen(Vec3d x) { return {x.x, x.y, x.z}; }

/// Tetrahedra of a block of 70 x 60 x 40 mm with displaced inner vertices, fixed at z = 0.
sfem::Body irregular_block() {
  const Int3 cells{14, 12, 8};
  constexpr double kCell = 5e-3;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> off(-0.18 * kCell, 0.18 * kCell);
  sfem::Body body;
  const auto vertex = [&](Int3 p) { return (p.z * (cells.y + 1) + p.y) * (cells.x + 1) + p.x; };
  for (int k = 0; k <= cells.z; k++)
    for (int j = 0; j <= cells.y; j++)
      for (int i = 0; i <= cells.x; i++) {
        Vec3d x = Vec3d{double(i), double(j), double(k)} * kCell;
        for (int axis = 0; axis < 3; axis++)
          if (const int n = Int3{i, j, k}[axis]; n > 0 && n < cells[axis]) x[axis] += off(random);
        body.mesh.vertices.push_back(x);
        body.fixed.push_back(k == 0);
      }
  // six tetrahedra a cell, along the six orders of the axes
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int k = 0; k < cells.z; k++)
    for (int j = 0; j < cells.y; j++)
      for (int i = 0; i < cells.x; i++)
        for (int n = 0; n < 6; n++) {
          Int3 p{i, j, k};
          std::array<int, 4> tet{vertex(p)};
          for (std::size_t c = 1; c < 4; c++) p[kOrders[n][c - 1]]++, tet[c] = vertex(p);
          if (n >= 3) std::swap(tet[2], tet[3]);  // odd orders are left-handed
          Vec3d middle;
          for (const int v : tet) middle += body.mesh.vertices[std::size_t(v)] * 0.25;
          body.mesh.elements.insert(body.mesh.elements.end(), tet.begin(), tet.end());
          body.material.push_back(norm(middle - kMiddle) < kNoduleRadius);
        }
  body.materials = {kFlesh, kNodule};
  return body;
}

/// Stiffness matrix of all vertices, fixed ones included.
Matrix stiffness_of(const sfem::Body& body) {
  std::vector<Eigen::Triplet<double>> terms;
  for (std::size_t e = 0; e < body.material.size(); e++) {
    const int* tet = &body.mesh.elements[4 * e];
    // gradients of the shape functions: rows of the inverse of [1 x y z]
    Eigen::Matrix4d corners;
    for (int c = 0; c < 4; c++)
      corners.row(c) << 1, eigen(body.mesh.vertices[std::size_t(tet[c])]).transpose();
    const double volume = std::abs(corners.determinant()) / 6;
    const Eigen::Matrix<double, 3, 4> gradient = corners.inverse().bottomRows<3>();
    const sfem::Material& m = body.materials[std::size_t(body.material[e])];
    const double mu = m.young / (2 * (1 + m.poisson)),
                 lambda = m.young * m.poisson / ((1 + m.poisson) * (1 - 2 * m.poisson));
    for (int a = 0; a < 4; a++)
      for (int b = 0; b < 4; b++) {
        const Eigen::Vector3d p = gradient.col(a), q = gradient.col(b);
        const Eigen::Matrix3d block = volume * (lambda * p * q.transpose() + mu * q * p.transpose() +
                                                mu * p.dot(q) * Eigen::Matrix3d::Identity());
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++) terms.emplace_back(3 * tet[a] + i, 3 * tet[b] + j, block(i, j));
      }
  }
  const auto n = Eigen::Index(3 * body.mesh.vertices.size());
  Matrix k(n, n);
  k.setFromTriplets(terms.begin(), terms.end());
  return k;
}

/// Displacements of all vertices under forces, by the independent elements.
Eigen::VectorXd solved(const sfem::Body& body, const Matrix& k, const Eigen::VectorXd& force) {
  // rows of free vertices; the identity for fixed ones
  std::vector<Eigen::Triplet<double>> terms;
  const auto is_fixed = [&](Eigen::Index row) { return body.fixed[std::size_t(row / 3)] != 0; };
  Eigen::VectorXd right = force;
  for (Eigen::Index column = 0; column < k.outerSize(); column++)
    for (Matrix::InnerIterator term(k, column); term; ++term)
      if (!is_fixed(term.row()) && !is_fixed(term.col()))
        terms.emplace_back(term.row(), term.col(), term.value());
  for (Eigen::Index row = 0; row < k.rows(); row++)
    if (is_fixed(row)) terms.emplace_back(row, row, 1), right[row] = 0;
  Matrix free(k.rows(), k.cols());
  free.setFromTriplets(terms.begin(), terms.end());
  return Eigen::SimplicialLDLT<Matrix>(free).solve(right);
}

/// The block with tools pressed into its top, and the forces and displacements of its vertices.
struct PressedBlock {
  sfem::Body body = irregular_block();
  std::vector<Tool> tools;
  std::vector<ToolPose> poses;
  std::vector<ToolForce> forces;
  Eigen::VectorXd on_vertices, displacement;  // of the model; the displacements of the surface only
  std::vector<int> surface;                   // vertices of the patch
  double deepest = 0;                         // of a vertex inside a tool [m]

  PressedBlock(std::vector<Tool> by, const std::vector<Vec3d>& to) : tools(std::move(by)), forces(to.size()) {
    // model and patch over the whole surface, without refinement
    Result<sfem::Model> model = sfem::build(Exec(2), body, {.precision = sfem::Precision::kDouble});
    EXPECT_TRUE(model) << model.error().message;
    EXPECT_TRUE(sfem::compute_green(Exec(2), *model, std::size_t(1) << 32));
    const sfem::Patch patch =
        sfem::build_patch(*model, sfem::patch_elements(*model, to, 0.03), 1, to).value();
    TouchState state = make_touch_state(patch, tools.size(), {.capacity = 96});

    // a slow press from above to the final positions
    for (int tick = 1; tick <= 150; tick++) {
      poses.clear();
      const double high = 0.012 * std::max(0.0, 1 - tick / 100.0);
      for (const Vec3d x : to) poses.push_back({{x + Vec3d{0, 0, high}, {}}, false});
      solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
    }

    // forces and displacements by vertex
    const auto n = Eigen::Index(3 * body.mesh.vertices.size());
    on_vertices = displacement = Eigen::VectorXd::Zero(n);
    for (std::size_t p = 0; p < patch.points.size(); p++) {
      const sfem::PatchPoint& point = patch.points[p];
      EXPECT_EQ(point.supports, 1) << "every point of a coarse patch is a vertex";
      const int v = patch.coarse[std::size_t(point.coarse[0])];
      on_vertices.segment<3>(3 * v) += eigen(state.force[p]);
      displacement.segment<3>(3 * v) = eigen(state.u[p]);
      surface.push_back(v);
      for (std::size_t t = 0; t < tools.size(); t++)
        deepest = std::max(deepest, -distance(tools[t].shape, poses[t].pose, state.x[p]).distance);
    }
  }
};

/// Largest difference between the displacements of model and independent elements, relative to the largest.
double displacement_error(const PressedBlock& block, const Eigen::VectorXd& independent) {
  double worst = 0;
  for (const int v : block.surface)
    worst = std::max(worst, (block.displacement - independent).segment<3>(3 * v).norm());
  return worst / independent.lpNorm<Eigen::Infinity>();
}

/// Force of the fixed vertices on the body.
Vec3d reaction_of(const PressedBlock& block, const Matrix& k, const Eigen::VectorXd& independent) {
  const Eigen::VectorXd inner = k * independent;
  Vec3d sum;
  for (std::size_t v = 0; v < block.body.fixed.size(); v++) {
    if (!block.body.fixed[v]) continue;
    const Eigen::Vector3d f = inner.segment<3>(Eigen::Index(3 * v));
    sum += Vec3d{f.x(), f.y(), f.z()};
  }
  return sum;
}

void expect_independent_elements_agree(const PressedBlock& block) {
  const Matrix k = stiffness_of(block.body);
  const Eigen::VectorXd independent = solved(block.body, k, block.on_vertices);

  // displacements, tools and balance
  const double error = displacement_error(block, independent);
  EXPECT_LT(error, 1e-10) << "of the largest displacement";
  const double largest = independent.lpNorm<Eigen::Infinity>();
  EXPECT_GT(largest, 2e-3) << "m";
  EXPECT_LT(block.deepest, 0.01 * largest) << "m: no vertex is inside a tool";
  Vec3d on_tools;
  for (const ToolForce& tool : block.forces) on_tools += tool.force;
  const Vec3d holds = reaction_of(block, k, independent);
  EXPECT_LT(norm(holds - on_tools), 1e-9 * norm(on_tools) + 1e-12) << "N: the holds bear what the tools do";
  std::printf("tools bear %.4f N, the holds %.4f N; displacements differ by %.1e of the largest\n",
              norm(on_tools), norm(holds), error);
}

// A ball over a nodule has the independent displacements, and the holds' reaction is its force.
TEST(IndependentElements, PressOverNoduleAgrees) {
  const Vec3d top{kMiddle.x, kMiddle.y, 0.04};
  const PressedBlock block({{Sphere{0.01}, 0.3}}, {top + Vec3d{0, 0, 0.01 - 0.004}});
  expect_independent_elements_agree(block);
  const PressedBlock beside({{Sphere{0.01}, 0.3}}, {Vec3d{0.015, 0.03, 0.046}});
  expect_independent_elements_agree(beside);
  EXPECT_GT(block.forces[0].force.z, 1.3 * beside.forces[0].force.z) << "the nodule is stiffer";
}

// Two tools that press at once, near each other, have the independent displacements and balance.
TEST(IndependentElements, TwoToolsAgree) {
  const PressedBlock block({{Sphere{0.008}, 0.3}, {Capsule{0.006, 0.008}, 0.1}},
                           {Vec3d{0.025, 0.03, 0.0445}, Vec3d{0.044, 0.033, 0.05}});
  expect_independent_elements_agree(block);
  EXPECT_GT(block.forces[0].force.z, 0.01) << "N";
  EXPECT_GT(block.forces[1].force.z, 0.01) << "N";
}

}  // namespace
}  // namespace turgor::contact
