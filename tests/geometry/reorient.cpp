#include "turgor/geometry/reorient.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

LabelVolume make_labels() {
  LabelVolume v{{.size = {4, 3, 5}, .spacing = {1, 2, 3}, .origin = {7, -8, 9}, .axes = {}}, {}};
  for (std::uint16_t n = 0; n < 60; n++) v.samples.push_back(n);
  return v;
}

// Reordered axes keep the position of every sample.
TEST(Reorient, KeepsPositionsOfSamples) {
  const LabelVolume v = make_labels();
  const LabelVolume turned = reordered(v, AxisOrder{{2, 0, 1}, {true, false, true}});
  EXPECT_EQ(turned.grid.size, (Int3{5, 4, 3}));
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 4; j++)
      for (int i = 0; i < 5; i++) {
        const Vec3d p = index_at(v.grid, point_at(turned.grid, {double(i), double(j), double(k)}));
        EXPECT_EQ(turned.at(i, j, k),
                  v.at(int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))));
      }
}

// on_grid restores the samples on the original grid.
TEST(Reorient, RestoresOriginalGrid) {
  const LabelVolume v = make_labels();
  const auto back = on_grid(reordered(v, AxisOrder{{1, 2, 0}, {false, true, true}}), v.grid);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->samples, v.samples);
}

// on_grid rejects a grid that is shifted or has another spacing.
TEST(Reorient, RejectsDifferentGrid) {
  const LabelVolume v = make_labels();
  Grid shifted = v.grid, finer = v.grid;
  shifted.origin.x += 0.5;
  finer.spacing.y = 1.9;
  EXPECT_FALSE(on_grid(v, shifted));
  EXPECT_FALSE(on_grid(v, finer));
}

// Grids are the same within a tolerance for rounding.
TEST(Reorient, SameGrid_ToleratesRounding) {
  const Grid a = make_labels().grid;
  Grid b = a;
  b.origin.x += 0.005;
  EXPECT_TRUE(same_grid(a, b));
  b.origin.x += 0.02;
  EXPECT_FALSE(same_grid(a, b));
}

// A left-handed volume becomes right-handed and keeps its samples' positions.
TEST(Reorient, LeftHandedBecomesRightHanded) {
  LabelVolume v = make_labels();
  v.grid.axes.column[0] = {-1, 0, 0};
  const LabelVolume right = right_handed(v);
  EXPECT_DOUBLE_EQ(determinant(right.grid.axes), 1);
  EXPECT_EQ(right.at(0, 0, 0), v.at(3, 0, 0));
}

}  // namespace
}  // namespace turgor
