#include "turgor/geometry/embedding.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"

namespace turgor {
namespace {

Vec3d affine(Vec3d p) {
  return {0.1 + 0.3 * p.x - 0.2 * p.y, 0.05 * p.x + 0.1 * p.y + 0.2 * p.z, -0.1 + 0.4 * p.z - 0.1 * p.x};
}

std::vector<Vec3d> displaced(const SolidMesh& mesh) {
  std::vector<Vec3d> u;
  for (const Vec3d x : mesh.vertices) u.push_back(affine(x));
  return u;
}

SolidMesh skewed_block() {
  SolidMesh block = hex_block({1, 1, 1}, {4, 3, 5});
  for (Vec3d& x : block.vertices) x = {x.x + 0.2 * x.y * x.z, x.y + 0.1 * x.x * x.z, x.z + 0.15 * x.x * x.y};
  return block;
}

// An affine displacement of the mesh moves embedded vertices exactly, inside and outside of it.
TEST(Embedding, ReproducesAffineDisplacements) {
  const TriMesh ball = test::sphere_surface({0.5, 0.5, 0.5}, 0.55, 3);  // its poles are outside
  for (const SolidMesh& mesh : {tetrahedralize(hex_block({1, 1, 1}, {4, 3, 5})), skewed_block()}) {
    const Embedding embedding = embed(Exec(2), ball, mesh);
    EXPECT_GT(embedding.farthest_outside, 0.01);
    std::vector<Vec3> moved(ball.vertices.size());
    move(embedding, displaced(mesh), moved);
    for (std::size_t v = 0; v < moved.size(); v++) {
      const Vec3d p(ball.vertices[v]);
      ASSERT_LT(norm(Vec3d(moved[v]) - p - affine(p)), 3e-6) << v;
    }
  }
}

// Weights sum to one and are not negative for vertices inside of the mesh.
TEST(Embedding, WeightsArePartitionOfUnity) {
  const TriMesh ball = test::sphere_surface({0.55, 0.55, 0.55}, 0.4, 3);
  for (const SolidMesh& mesh : {tetrahedralize(hex_block({1, 1, 1}, {4, 3, 5})), skewed_block()}) {
    const Embedding embedding = embed(Exec(2), ball, mesh);
    EXPECT_EQ(embedding.farthest_outside, 0);
    const std::size_t corners = std::size_t(mesh.corners);
    for (std::size_t v = 0; v < ball.vertices.size(); v++) {
      double sum = 0;
      for (std::size_t c = v * corners; c < (v + 1) * corners; c++) {
        sum += double(embedding.weights[c]);
        ASSERT_GE(embedding.weights[c], -1e-6f);
      }
      ASSERT_NEAR(sum, 1, 1e-6);
    }
  }
}

// One and four threads select the same elements and weights.
TEST(Embedding, EqualElementsOnAnyThreads) {
  const TriMesh ball = test::sphere_surface({0.5, 0.5, 0.5}, 0.55, 3);
  const SolidMesh mesh = tetrahedralize(hex_block({1, 1, 1}, {4, 3, 5}));
  const Embedding one = embed(Exec(1), ball, mesh), four = embed(Exec(4), ball, mesh);
  EXPECT_EQ(one.nodes, four.nodes);
  EXPECT_EQ(one.weights, four.weights);
}

}  // namespace
}  // namespace turgor
