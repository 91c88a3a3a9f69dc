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

// A box of a grid is compared with the samples that it should cover: its size is no difference.
TEST(GridDifference, BoxIsComparedWithItsSamples) {
  const Grid ct{.size = {10, 20, 30}, .spacing = {1e-3, 1e-3, 2e-3}, .origin = {0.1, 0.2, 0.3}, .axes = {}};
  Grid box = ct;
  box.size = {4, 5, 6};
  box.origin = point_at(ct, {2, 3, 4});
  const Grid sound = box;
  box.origin.z += 1e-3;
  EXPECT_EQ(box_difference(box, ct),
            "origin 102, 203, 309 mm between samples, the nearest at 102, 203, 310 mm");
  box = sound, box.origin.z += 5e-5;  // a twentieth of the finest spacing
  EXPECT_EQ(box_difference(box, ct),
            "origin 102, 203, 308.05 mm between samples, the nearest at 102, 203, 308 mm");
  box = sound, box.spacing.z = 3e-3;
  EXPECT_EQ(box_difference(box, ct), "spacing 1 x 1 x 3 mm, not 1 x 1 x 2 mm");
  box.size.z = 1, box.origin.x -= 3e-3;  // the spacing of a single plane is no difference
  EXPECT_EQ(box_difference(box, ct),
            "origin 99, 203, 308 mm: it reaches from sample (-1, 3, 4) to (2, 7, 4), outside of 10 x 20 x 30 "
            "samples");
  box = sound, box.size.y = 18;
  EXPECT_EQ(
      box_difference(box, ct),
      "origin 102, 203, 308 mm: it reaches from sample (2, 3, 4) to (5, 20, 9), outside of 10 x 20 x 30 "
      "samples");
  box = sound;
  const double c = std::cos(0.1), s = std::sin(0.1);
  box.axes = {{Vec3d{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
  EXPECT_EQ(box_difference(box, ct).substr(0, 16), "axes turned by 5");
}

// The order and the direction of a box's axes are no difference.
TEST(GridDifference, BoxMayBeReversed) {
  const Grid ct{.size = {10, 20, 30}, .spacing = {1e-3, 1e-3, 2e-3}, .origin = {0.1, 0.2, 0.3}, .axes = {}};
  Grid box = ct;
  box.size = {4, 5, 6};
  box.axes.column[0] = {-1, 0, 0};
  box.origin = point_at(ct, {5, 3, 4.5});
  EXPECT_EQ(box_difference(box, ct),
            "origin 102, 203, 309 mm between samples, the nearest at 102, 203, 310 mm");
}

}  // namespace
}  // namespace turgor
