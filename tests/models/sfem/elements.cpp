#include "turgor/models/sfem/elements.hpp"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/dense.hpp"

namespace turgor::sfem {
namespace {

constexpr Vec3d kSize{0.3, 0.2, 0.25};

SolidMesh distorted_block(int corners) {
  SolidMesh mesh = hex_block(kSize, {3, 3, 3});
  distort(mesh, kSize, 0.02);
  return with_corners(mesh, corners);
}

Eigen::MatrixXd stiffness(const SolidMesh& mesh, Material material, Formulation formulation) {
  const std::vector<int> first(element_count(mesh), 0);
  return dense(assemble(Exec(1), mesh, std::span(&material, 1), first, formulation));
}

// Patch test: a linear displacement of the border is linear inside, on distorted meshes.
TEST(SfemElements, PatchTestOnDistortedMeshes) {
  for (const auto [corners, formulation] : kCases) {
    const SolidMesh mesh = distorted_block(corners);
    const Eigen::MatrixXd k = stiffness(mesh, {1e4, 0.3}, formulation);
    const auto n = Eigen::Index(mesh.vertices.size());
    Eigen::VectorXd linear(3 * n);
    std::vector<Eigen::Index> inside, border;
    for (Eigen::Index v = 0; v < n; v++) {
      const Vec3d x = mesh.vertices[std::size_t(v)];
      linear[3 * v] = 0.01 * x.x + 0.02 * x.y - 0.005 * x.z;
      linear[3 * v + 1] = -0.015 * x.x + 0.03 * x.z;
      linear[3 * v + 2] = 0.02 * x.x + 0.01 * x.y + 0.04 * x.z;
      for (int i = 0; i < 3; i++) (on_box(x, kSize) ? border : inside).push_back(3 * v + i);
    }
    const Eigen::VectorXd u = k(inside, inside).ldlt().solve(-k(inside, border) * linear(border));
    EXPECT_LT((u - linear(inside)).norm(), 1e-12 * linear.norm()) << corners << " corners";
  }
}

// The stiffness matrix is exactly symmetric and has six rigid modes.
TEST(SfemElements, StiffnessHasSixRigidModes) {
  for (const auto [corners, formulation] : kCases) {
    const Eigen::MatrixXd k = stiffness(distorted_block(corners), {1e4, 0.3}, formulation);
    EXPECT_EQ(k, k.transpose());
    const Eigen::VectorXd energy = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
    EXPECT_LT(energy.head(6).cwiseAbs().maxCoeff(), 1e-12 * energy.tail(1)[0]) << corners << " corners";
    EXPECT_GT(energy[6], 1e-6 * energy.tail(1)[0]) << corners << " corners";
  }
}

// A single element has six rigid modes.
TEST(SfemElements, SingleElementHasSixRigidModes) {
  for (const auto [corners, formulation] : kCases) {
    SolidMesh mesh = hex_block({1, 1, 1}, {1, 1, 1});
    if (corners != 8) mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 4, {0, 1, 2, 3}, {}};
    if (corners == 10) mesh = with_middles(mesh);
    const Eigen::MatrixXd k = stiffness(mesh, {1, 0.4}, formulation);
    const Eigen::VectorXd energy = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
    EXPECT_LT(energy.head(6).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_GT(energy[6], 0.01);
  }
}

// A uniform strain has the energy of Hooke's law in every formulation.
TEST(SfemElements, UniformStrainHasHookeEnergy) {
  const Material material{2e4, 0.45};
  const auto [bulk, shear] = moduli(material);
  for (const auto [corners, formulation] : kCases) {
    const SolidMesh mesh = distorted_block(corners);
    const Eigen::MatrixXd k = stiffness(mesh, material, formulation);
    Eigen::VectorXd u(k.rows());
    for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
      const Vec3d x = mesh.vertices[v];
      u.segment<3>(3 * Eigen::Index(v)) << 0.02 * x.x + 0.04 * x.y, -0.01 * x.y, 0.03 * x.z;
    }
    // Strains 0.02, -0.01, 0.03 and a shear of 0.02: ½ bulk θ² + shear |deviator|², times the volume.
    const double theta = 0.04, mean = theta / 3;
    const double deviator =
        std::pow(0.02 - mean, 2) + std::pow(-0.01 - mean, 2) + std::pow(0.03 - mean, 2) + 2 * 0.02 * 0.02;
    const double expected = (0.5 * bulk * theta * theta + shear * deviator) * volume(mesh);
    EXPECT_NEAR(0.5 * u.dot(k * u), expected, 1e-12 * expected) << corners << " corners";
  }
}

// Assembly gives the same bits on one, two and eight threads.
TEST(SfemElements, AssemblyEqualBitsOnAnyThreads) {
  const Material materials[] = {{1e4, 0.3}, {5e4, 0.49}};
  for (const auto [corners, formulation] : kCases) {
    SolidMesh mesh = hex_block({1, 1, 1}, {7, 6, 5});
    mesh = with_corners(mesh, corners);
    std::vector<int> material(element_count(mesh));
    for (std::size_t e = 0; e < material.size(); e++) material[e] = int(e / 3 % 2);
    const BlockMatrix one = assemble(Exec(1), mesh, materials, material, formulation);
    for (const int threads : {2, 8}) {
      const BlockMatrix many = assemble(Exec(threads), mesh, materials, material, formulation);
      EXPECT_EQ(one.column, many.column);
      EXPECT_EQ(one.value, many.value);
    }
  }
}

// Elements inside inclusions have the material of the last one.
TEST(SfemElements, LastInclusionSetsMaterial) {
  Body body = block_of(hex_block({4, 1, 1}, {4, 1, 1}), {1, 0.3}, [](Vec3d x) { return x.x == 0; });
  body.materials.resize(3, {2, 0.3});
  body.material = {0, 0, 0, 1};
  body.inclusions = {{{1.5, 0.5, 0.5}, 1.1, 1}, {{1.5, 0.5, 0.5}, 0.1, 2}};
  EXPECT_EQ(element_materials(body), (std::vector<int>{1, 2, 1, 1}));
}

// Nodal volumes fill the body, and a translation does not change them.
TEST(SfemElements, NodalVolumesFillBody) {
  const SolidMesh mesh = distorted_block(4);
  std::vector<int> material(element_count(mesh), 0);
  for (std::size_t e = 0; e < material.size(); e++) material[e] = e % 3 == 0;
  const NodalVolumes volumes = nodal_volumes(mesh, material);
  double sum = 0;
  for (std::size_t n = 0; n < volumes.volume.size(); n++) {
    sum += volumes.volume[n];
    Vec3d change;
    double swelling = 0;
    for (std::size_t i = volumes.vertices.begin[n]; i < volumes.vertices.begin[n + 1]; i++) {
      change += volumes.gradient[i];
      swelling += dot(volumes.gradient[i], mesh.vertices[std::size_t(volumes.vertices.item[i])]);
    }
    EXPECT_LT(norm(change), 1e-17);
    EXPECT_NEAR(swelling, 3 * volumes.volume[n],
                1e-15);  // u = x: a uniform expansion changes the volume by three times itself
  }
  EXPECT_NEAR(sum, volume(mesh), 1e-15);
}

}  // namespace
}  // namespace turgor::sfem
