#include "turgor/geometry/distance_transform.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

const Grid kGrid{.size = {11, 9, 7}, .spacing = {0.8, 1.1, 2.5}, .origin = {}, .axes = {}};

// Every distance equals the minimum over all set samples.
TEST(DistanceTransform, MatchesBruteForce) {
  std::mt19937 random(2);
  std::vector<std::uint8_t> set(sample_count(kGrid));
  std::vector<Vec3d> set_points;
  for (std::size_t i = 0; i < set.size(); i++)
    if (random() % 40 == 0) {
      set[i] = 1;
      set_points.push_back(point_at(kGrid, {double(i % 11), double(i / 11 % 9), double(i / 99)}));
    }
  const std::vector<float> distance = distance_transform(Exec(2), kGrid, set);
  for (std::size_t i = 0; i < set.size(); i++) {
    const Vec3d p = point_at(kGrid, {double(i % 11), double(i / 11 % 9), double(i / 99)});
    double nearest = 1e9;
    for (const Vec3d q : set_points) nearest = std::min(nearest, norm(p - q));
    EXPECT_NEAR(distance[i], nearest, 1e-5);
  }
}

// Distances are infinite if no sample is set.
TEST(DistanceTransform, InfiniteWithoutSetSamples) {
  for (const float d : distance_transform(Exec(1), kGrid, std::vector<std::uint8_t>(sample_count(kGrid))))
    EXPECT_EQ(d, std::numeric_limits<float>::infinity());
}

// Gaussian smoothing keeps a constant everywhere and a linear function away from the border.
TEST(DistanceTransform, SmoothingKeepsLinearFunctions) {
  Grid grid = kGrid;
  grid.size = {31, 25, 21};
  std::vector<float> linear, constant(sample_count(grid), 3.5f);
  for (int k = 0; k < 21; k++)
    for (int j = 0; j < 25; j++)
      for (int i = 0; i < 31; i++) linear.push_back(float(i) + 2 * float(j) - float(k));
  const std::vector<float> before = linear;
  smooth_gaussian(Exec(2), grid, 1.5, linear);
  smooth_gaussian(Exec(2), grid, 1.5, constant);
  for (const float c : constant) EXPECT_NEAR(c, 3.5f, 1e-5);
  for (int k = 3; k < 18; k++)
    for (int j = 6; j < 19; j++)
      for (int i = 6; i < 25; i++) {
        const std::size_t at = sample_index(grid, i, j, k);
        EXPECT_NEAR(linear[at], before[at], 1e-4);
      }
}

// A smoothed peak has the standard deviation of the Gaussian.
TEST(DistanceTransform, SmoothedPeakHasGaussianWidth) {
  Grid grid{.size = {41, 41, 41}, .spacing = {0.5, 0.5, 0.5}, .origin = {}, .axes = {}};
  std::vector<float> peak(sample_count(grid));
  peak[sample_index(grid, 20, 20, 20)] = 1;
  smooth_gaussian(Exec(1), grid, 2.0, peak);
  double spread = 0, sum = 0;
  for (int i = 0; i < 41; i++) {
    const double weight = double(peak[sample_index(grid, i, 20, 20)]), x = (i - 20) * 0.5;
    sum += weight, spread += weight * x * x;
  }
  EXPECT_NEAR(std::sqrt(spread / sum), 2.0, 0.05);
}

}  // namespace
}  // namespace turgor
