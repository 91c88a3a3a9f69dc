// Maps of heights: cubic curves through the samples, their derivatives, and their bounds.
#include "turgor/contact/height_map.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace turgor::contact {
namespace {

HeightMap random_map(int columns, int rows) {
  std::uint32_t seed = 3;
  std::vector<double> height(std::size_t(columns) * std::size_t(rows));
  for (double& h : height) h = 5e-6 * double((seed = seed * 1664525u + 1013904223u) >> 16) / 65536;
  return make_height_map(columns, rows, 3e-4, std::move(height));
}

// The map passes through its samples and repeats in both directions.
TEST(HeightMap, PassesThroughSamplesAndRepeats) {
  const HeightMap map = random_map(5, 7);
  for (int j = -8; j < 15; j++)
    for (int i = -6; i < 11; i++) {
      const double sample = map.height[std::size_t((j + 14) % 7 * 5 + (i + 10) % 5)];
      EXPECT_NEAR(sample_height(map, (i + 1e-9) * map.spacing, (j + 1e-9) * map.spacing).height, sample,
                  1e-12);
    }
}

// First and second derivatives are those of the heights; no second derivative exceeds the map's bound.
TEST(HeightMap, DerivativesAreThoseOfHeights) {
  const HeightMap map = random_map(6, 4);
  constexpr double kStep = 1e-7;
  double most = 0;
  for (int n = 0; n < 400; n++) {
    const double u = 1.1e-3 * std::sin(n * 1.7), v = 0.9e-3 * std::cos(n * 2.3);
    const double across = u / map.spacing, along = v / map.spacing;
    if (std::abs(across - std::round(across)) < 0.01 || std::abs(along - std::round(along)) < 0.01)
      continue;  // second derivatives jump at samples
    const HeightSample s = sample_height(map, u, v);
    const HeightSample right = sample_height(map, u + kStep, v), left = sample_height(map, u - kStep, v),
                       up = sample_height(map, u, v + kStep), down = sample_height(map, u, v - kStep);
    EXPECT_NEAR(s.u, (right.height - left.height) / (2 * kStep), 1e-5);
    EXPECT_NEAR(s.v, (up.height - down.height) / (2 * kStep), 1e-5);
    EXPECT_NEAR(s.uv, (up.u - down.u) / (2 * kStep), 0.05 * map.curvature);
    EXPECT_NEAR(s.uu, (right.u - left.u) / (2 * kStep), 0.05 * map.curvature);
    EXPECT_NEAR(s.vv, (up.v - down.v) / (2 * kStep), 0.05 * map.curvature);
    most = std::max({most, std::abs(s.uu), std::abs(s.vv), std::abs(s.uv)});
  }
  EXPECT_LT(most, 1.02 * map.curvature);
  EXPECT_GT(most, 0.5 * map.curvature);
}

// A row of a sine has the slope and the curvature of the sine.
TEST(HeightMap, ProfileOfSine) {
  constexpr int kCount = 40;
  constexpr double kHeight = 2e-6, kSpacing = 1e-4, kLength = kCount * kSpacing;
  std::vector<double> height;
  const double k = 2 * std::numbers::pi / kLength;
  for (int i = 0; i < kCount; i++) height.push_back(kHeight * std::sin(k * i * kSpacing));
  const HeightMap map = make_height_map(kCount, 1, kSpacing, height);
  EXPECT_NEAR(map.curvature, kHeight * k * k, 0.05 * kHeight * k * k);
  EXPECT_NEAR(map.range, 2 * kHeight, 1e-8);
  for (int n = 0; n < 100; n++) {
    const double u = 1e-3 * std::sin(n * 1.1);
    EXPECT_NEAR(sample_height(map, u, 0.3).u, kHeight * k * std::cos(k * u), 0.01 * kHeight * k);
    EXPECT_EQ(sample_height(map, u, 0.3).v, 0);
  }
}

}  // namespace
}  // namespace turgor::contact
