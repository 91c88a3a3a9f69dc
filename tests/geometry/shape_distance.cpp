#include "turgor/geometry/shape_distance.hpp"

#include <random>

#include <gtest/gtest.h>

#include "turgor/geometry/pose.hpp"

namespace turgor {
namespace {

// The distance to a rod is that to the nearest of many balls along its axis.
TEST(ShapeDistance, RodMatchesBallsAlongAxis) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-0.05, 0.05);
  constexpr double kRadius = 0.007, kHalf = 0.02;
  constexpr int kBalls = 20000;
  for (int n = 0; n < 50; n++) {
    const Vec3d x{number(random), number(random), number(random)};
    double least = 1;
    for (int ball = 0; ball <= kBalls; ball++)
      least = std::min(least, ball_distance({0, 0, kHalf * (2.0 * ball / kBalls - 1)}, kRadius, x).distance);
    const ShapeDistance found = rod_distance(kRadius, kHalf, x);
    EXPECT_NEAR(found.distance, least, 1e-8) << "m";
    EXPECT_NEAR(rod_distance(kRadius, kHalf, x - found.normal * found.distance).distance, 0, 1e-12) << "m";
    EXPECT_EQ(rod_distance(kRadius, 0, x).distance, ball_distance({}, kRadius, x).distance);
  }
}

// A grid of distances to a plane interpolates them exactly.
TEST(ShapeDistance, GridInterpolatesPlane) {
  const Vec3d normal = normalized(Vec3d{1, 2, -0.5}), corner{-0.01, 0.02, 0.03};
  const double spacing = 0.004;
  const Int3 size{5, 4, 6};
  std::vector<DistanceNode> nodes;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        nodes.push_back({float(dot(normal, corner + Vec3d(Int3{i, j, k}) * spacing) - 0.04), Vec3(normal)});
  const DistanceGrid grid{corner, spacing, size, nodes.data()};
  EXPECT_EQ(grid.count(), nodes.size());
  for (const Vec3d fraction :
       {Vec3d{0.1, 0.2, 0.3}, Vec3d{0.5, 0.9, 0.4}, Vec3d{0.99, 0.98, 0.97}, Vec3d{0.01, 0.02, 0}}) {
    const Vec3d x = corner + hadamard(fraction, Vec3d(size) - Vec3d{1, 1, 1}) * spacing;
    const ShapeDistance found = grid_distance(grid, x);
    EXPECT_NEAR(found.distance, dot(normal, x) - 0.04, 1e-8) << "m";
    EXPECT_LT(norm(found.normal - normal), 1e-6);
  }
}

// to_tool inverts to_world for a rotated pose.
TEST(ShapeDistance, PoseRoundTrip) {
  const double c = std::cos(0.7), s = std::sin(0.7);
  const Pose pose{.position = {1, 2, 3}, .axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}}};
  const Vec3d x{0.3, -0.2, 0.5};
  EXPECT_LT(norm(to_tool(pose, to_world(pose, x)) - x), 1e-15);
  EXPECT_LT(norm(to_world(pose, {1, 0, 0}) - Vec3d{1 + c, 2 + s, 3}), 1e-15);
}

}  // namespace
}  // namespace turgor
