#include "turgor/geometry/triangle_tree.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"

namespace turgor {
namespace {

std::vector<Vec3d> doubles(const std::vector<Vec3>& x) {
  std::vector<Vec3d> result;
  for (const Vec3 p : x) result.push_back(Vec3d(p));
  return result;
}

// The nearest point is that of all triangles.
TEST(TriangleTree, NearestPointMatchesBruteForce) {
  const TriMesh ball = test::sphere_surface({0.1, 0.2, 0.3}, 1, 2);
  const TriangleTree tree = build_triangle_tree(doubles(ball.vertices), ball.triangles);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (int i = 0; i < 500; i++) {
    const Vec3d p{coordinate(random), coordinate(random), coordinate(random)};
    double nearest = 1e9;
    for (const auto [a, b, c] : tree.triangles) {
      const auto& x = tree.vertices;
      nearest = std::min(
          nearest, nearest_on_triangle(p, x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)]).distance);
    }
    const TrianglePoint at = nearest_point(tree, p);
    EXPECT_NEAR(at.distance, nearest, 1e-15) << "two compiled versions may contract products differently";
    EXPECT_NEAR(norm(p - at.position), at.distance, 1e-15);
  }
}

// Barycentric weights locate the nearest point on the face, an edge or a corner.
TEST(TriangleTree, WeightsLocateNearestPoint) {
  const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  EXPECT_EQ(nearest_on_triangle({0.25, 0.25, 2}, a, b, c).weights, (Vec3d{0.5, 0.25, 0.25}));
  EXPECT_EQ(nearest_on_triangle({0.25, -1, 0}, a, b, c).weights, (Vec3d{0.75, 0.25, 0}));
  EXPECT_EQ(nearest_on_triangle({1, 1, 1}, a, b, c).weights, (Vec3d{0, 0.5, 0.5}));
  EXPECT_EQ(nearest_on_triangle({-1, -1, 3}, a, b, c).weights, (Vec3d{1, 0, 0}));
  EXPECT_EQ(nearest_on_triangle({3, -1, 0}, a, b, c).weights, (Vec3d{0, 1, 0}));
}

// A triangle without area has a nearest point too.
TEST(TriangleTree, DegenerateTriangleHasNearestPoint) {
  const TrianglePoint at = nearest_on_triangle({0.5, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0.25, 0, 0});
  EXPECT_EQ(at.position, (Vec3d{0.5, 0, 0}));
  EXPECT_EQ(nearest_on_triangle({0, 2, 0}, {}, {}, {}).distance, 2);
}

}  // namespace
}  // namespace turgor
