#include "turgor/geometry/grid_difference.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// The message names the first property that differs: size, spacing, origin or axes.
TEST(GridDifference, NamesFirstDifference) {
  const Grid ct{.size = {10, 20, 30}, .spacing = {1e-3, 1e-3, 2e-3}, .origin = {0.1, 0.2, 0.3}, .axes = {}};
  Grid other = ct;
  other.size.z = 29;
  EXPECT_EQ(grid_difference(other, ct), "size 10 x 20 x 29, not 10 x 20 x 30");
  other = ct, other.spacing.z = 3e-3;
  EXPECT_EQ(grid_difference(other, ct), "spacing 1 x 1 x 3 mm, not 1 x 1 x 2 mm");
  other = ct, other.origin.x = 0.11;
  EXPECT_EQ(grid_difference(other, ct), "origin 110, 200, 300 mm, not 100, 200, 300 mm");
  other = ct;
  const double c = std::cos(0.1), s = std::sin(0.1);
  other.axes = {{Vec3d{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
  EXPECT_EQ(grid_difference(other, ct).substr(0, 16), "axes turned by 5");
}

// A reversed axis with a shifted origin is reported as a shift of the origin only.
TEST(GridDifference, ReversedAxesAreNoDifference) {
  const Grid ct{.size = {10, 20, 30}, .spacing = {1e-3, 1e-3, 2e-3}, .origin = {0.1, 0.2, 0.3}, .axes = {}};
  Grid mirrored = ct;
  mirrored.axes.column[0] = {-1, 0, 0};
  mirrored.origin.x += 9e-3 + 5e-3;
  EXPECT_EQ(grid_difference(mirrored, ct), "origin 105, 200, 300 mm, not 100, 200, 300 mm");
}

}  // namespace
}  // namespace turgor
