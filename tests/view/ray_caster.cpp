#include "turgor/view/ray_caster.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"
#include "turgor/view/color.hpp"
#include "turgor/view/smooth.hpp"

namespace turgor {
namespace {

constexpr int kWidth = 64, kHeight = 48;
// Black smoke: it absorbs but emits no light. A pixel is the backdrop times the transmittance.
constexpr TransferPoint kSmoke[] = {{-900, 0, {}}, {-800, 0.01f, {}}, {500, 0.01f, {}}, {900, 0.9f, {}}};

// Transmittance at the center of the picture.
float shine_through(const CtVolume& ct, const Camera& camera) {
  const Transfer transfer(kSmoke);
  const CtVolume smooth = smooth_half(Exec(1), ct);
  const OpacityBlocks blocks = build_opacity_blocks(Exec(1), ct, transfer);
  const RayCaster caster = make_ray_caster(ct, smooth, transfer, blocks, camera, kWidth, kHeight);
  return caster.pixel(kWidth / 2, kHeight / 2).y / backdrop(0.5f, 0.5f).y;
}

// Transmittance through a cloud is exponential in its thickness, for any spacing.
TEST(RayCaster, TransmittanceIsExponential) {
  for (const double spacing : {0.0005, 0.001, 0.002}) {
    const int count = int(std::lround(0.1 / spacing));
    const Grid grid =
        test::centered_grid({count, count, count}, {spacing, spacing, spacing}, {}, test::oblique_axes());
    for (const double radius : {0.01, 0.02, 0.03}) {
      const CtVolume ct = test::fill_volume(grid, [=](Vec3d x) { return norm(x) < radius ? 0.0 : -1000.0; });
      for (const Vec3d eye : {Vec3d{0, -0.4, 0}, {0.3, 0.2, -0.1}}) {
        const double expected = std::pow(0.99, 2e3 * radius);  // 1 % is absorbed per millimeter
        const double border = 40 * spacing;                    // two samples on each side, where values fade
        EXPECT_NEAR(shine_through(ct, {.eye = eye, .target = {}}), expected, border * expected);
      }
    }
  }
}

// Empty-space skipping does not miss plates that are one sample thick.
TEST(RayCaster, ThinPlatesAreNotSkipped) {
  // Opaque and one sample thick, behind clear air and behind a cloud.
  const Grid grid = test::centered_grid({80, 80, 80}, {0.001, 0.001, 0.001}, {});
  for (const int cloud : {-1000, -890}) {
    for (int j = 5; j < 75; j += 7) {
      CtVolume ct = test::fill_volume(grid, [=](Vec3d) { return cloud; });
      const float without = shine_through(ct, {.eye = {0, -0.4, 0}, .target = {}});
      for (int k = 0; k < 80; k++)
        for (int i = 0; i < 80; i++) ct.at(i, j, k) = 1000;
      EXPECT_LT(shine_through(ct, {.eye = {0, -0.4, 0}, .target = {}}), 0.6f * without) << j;
    }
  }
}

// Rays that miss the volume show the backdrop.
TEST(RayCaster, MissingRaysShowBackdrop) {
  const Grid grid = test::centered_grid({20, 20, 20}, {0.001, 0.001, 0.001}, {});
  const CtVolume ct = test::fill_volume(grid, [](Vec3d) { return 0; });
  EXPECT_EQ(shine_through(ct, {.eye = {0, -0.4, 0.2}, .target = {0, 0, 0.2}}), 1);
  EXPECT_EQ(shine_through(ct, {.eye = {0, -0.4, 0}, .target = {0, -1, 0}}),
            1);  // the volume is behind the eye
}

}  // namespace
}  // namespace turgor
