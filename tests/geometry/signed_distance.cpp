#include "turgor/geometry/signed_distance.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"
#include "turgor/geometry/stuffing.hpp"

namespace turgor {
namespace {

// The signed distance to a box of triangles is exact inside and outside, near edges and corners too.
TEST(SignedDistance, TriangleBoxIsExact) {
  const SignedDistance shape = distance_to_surface(test::box_surface({1, 2, 3}));
  for (double x = -1; x <= 2; x += 0.17)
    for (double y = -1; y <= 3; y += 0.19)
      for (double z = -1; z <= 4; z += 0.23) {
        const Vec3d middle{0.5, 1, 1.5}, p{x, y, z}, d = max(p - middle, middle - p) - middle;
        const double exact = norm(max(d, Vec3d{})) + std::min(0.0, std::max({d.x, d.y, d.z}));
        ASSERT_NEAR(shape.at(p), exact, 1e-12) << x << " " << y << " " << z;
      }
}

// The sign is correct next to the reflex edge of a notch.
TEST(SignedDistance, SignIsCorrectAtReflexEdge) {
  // A wedge of 300 degrees: the nearest point of every position in the notch is near the reflex edge.
  const TriMesh surface = test::notched_surface();
  const SignedDistance shape = distance_to_surface(surface);
  EXPECT_GT(shape.at({0, 0.02, 0.5}), 0);
  EXPECT_LT(shape.at({0, -0.02, 0.5}), 0);
  EXPECT_GT(shape.at({0.05, 0.5, 0.5}), 0);
  EXPECT_LT(shape.at({0.6, 0.1, 0.5}), 0);
}

/// Voxels of a ball whose center and axes match no sample.
struct Ball {
  Grid grid;
  std::vector<std::uint8_t> inside;
  double voxel_volume = 0;  // [m³]
};
Ball tilted_ball(Vec3d spacing, double radius) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  Ball ball{
      {.spacing = spacing, .origin = {0.3, -0.2, 0.1}, .axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}}}, {}, 0};
  for (int axis = 0; axis < 3; axis++) ball.grid.size[axis] = int(2.4 * radius / spacing[axis]) + 3;
  const Vec3d center = point_at(ball.grid, Vec3d(ball.grid.size) * 0.5 + Vec3d{-0.4, 0.2, 0.1});
  for (int k = 0; k < ball.grid.size.z; k++)
    for (int j = 0; j < ball.grid.size.y; j++)
      for (int i = 0; i < ball.grid.size.x; i++)
        ball.inside.push_back(norm(point_at(ball.grid, {double(i), double(j), double(k)}) - center) < radius);
  ball.voxel_volume =
      double(std::count(ball.inside.begin(), ball.inside.end(), 1)) * sample_volume(ball.grid);
  return ball;
}

/// Volume of the inside, sampled on a fine grid of another orientation [m³].
double sampled_volume(const SignedDistance& shape, double step) {
  double count = 0;
  for (double x = shape.low.x; x < shape.high.x; x += step)
    for (double y = shape.low.y; y < shape.high.y; y += step)
      for (double z = shape.low.z; z < shape.high.z; z += step) count += shape.at({x, y, z}) < 0;
  return count * step * step * step;
}

// A smoothed ball of voxels keeps its volume within 1 %.
TEST(SignedDistance, SmoothedVoxelBallKeepsVolume) {
  const Exec exec(2);
  for (const Vec3d spacing : {Vec3d{3e-3, 3e-3, 3e-3}, Vec3d{0.8e-3, 0.9e-3, 5e-3}})
    for (const double smoothing : {2e-3, 5e-3}) {
      const Ball ball = tilted_ball(spacing, 0.025);
      const SignedDistance shape = distance_to_voxels(exec, ball.grid, ball.inside, smoothing);
      EXPECT_NEAR(sampled_volume(shape, 1e-3), ball.voxel_volume, 0.01 * ball.voxel_volume)
          << spacing.z << " " << smoothing;
    }
}

// The surface of voxels at the border of the grid is closed at the border.
TEST(SignedDistance, VoxelsAtBorderAreClosed) {
  Grid grid{.size = {4, 4, 4}, .spacing = {0.01, 0.01, 0.01}, .origin = {}, .axes = {}};
  const SignedDistance shape = distance_to_voxels(Exec(1), grid, std::vector<std::uint8_t>(64, 1), 0.002);
  EXPECT_LT(shape.at({0.0, 0.015, 0.015}), -0.003);
  EXPECT_NEAR(shape.at({-0.005, 0.015, 0.015}), 0, 5e-4);
  EXPECT_GT(shape.at({-0.01, 0.015, 0.015}), 0.003);
  EXPECT_NEAR(shape.at({-1, 0.015, 0.015}), 0.995, 0.01);
}

}  // namespace
}  // namespace turgor
