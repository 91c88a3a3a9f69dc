#include "turgor/view/smooth.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"
#include "turgor/view/sample.hpp"

namespace turgor {
namespace {

// Smoothing to half the resolution reproduces linear fields.
TEST(Smooth, HalvingReproducesLinearField) {
  const auto field = [](Vec3d x) { return 3e4 * x.x - 2e4 * x.y + 1e4 * x.z; };
  const Grid grid =
      test::centered_grid({40, 32, 24}, {0.001, 0.001, 0.002}, {0.01, 0.02, 0.03}, test::oblique_axes());
  const CtVolume smooth = smooth_half(Exec(2), test::fill_volume(grid, field));
  EXPECT_EQ(smooth.grid.size, (Int3{20, 16, 12}));
  for (int k = 1; k < 11; k++)
    for (int j = 1; j < 15; j++)
      for (int i = 1; i < 19; i++)
        EXPECT_NEAR(smooth.at(i, j, k), field(point_at(smooth.grid, Vec3d(Int3{i, j, k}))), 2);
}

// Smoothing keeps a constant in volumes with odd or single-sample axes.
TEST(Smooth, HalvingKeepsConstant) {
  for (const Int3 size : {Int3{7, 5, 3}, {1, 9, 2}, {4, 1, 1}}) {
    const CtVolume ct =
        test::fill_volume(test::centered_grid(size, {0.001, 0.001, 0.001}, {}), [](Vec3d) { return 320; });
    for (const std::int16_t hu : smooth_half(Exec(1), ct).samples) EXPECT_EQ(hu, 320);
  }
}

// Trilinear interpolation reproduces linear fields and clamps outside of the grid.
TEST(Smooth, InterpolationReproducesLinearField) {
  const auto field = [](Vec3d x) { return 1e5 * x.x + 2e5 * x.y - 1e5 * x.z; };  // integers at the samples
  const Grid grid{.size = {6, 5, 4}, .spacing = {0.001, 0.001, 0.001}, .origin = {}, .axes = {}};
  const CtVolume ct = test::fill_volume(grid, field);
  for (const Vec3 index : {Vec3{0, 0, 0}, {5, 4, 3}, {1.25f, 2.5f, 0.75f}, {4.9f, 3.9f, 2.9f}}) {
    EXPECT_NEAR(sample_linear(ct, index), field(point_at(grid, Vec3d(index))), 1e-3);
    EXPECT_NEAR(sample_clamped(ct, index), field(point_at(grid, Vec3d(index))), 1e-3);
  }
  EXPECT_EQ(sample_clamped(ct, {-3, 0, 0}), ct.at(0, 0, 0));
}

}  // namespace
}  // namespace turgor
