#include "turgor/view/volume_view.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

constexpr int kWidth = 400, kHeight = 300;

Image draw(const CtVolume& ct, const Camera& camera, const char* preset = "bone", int threads = 2) {
  return draw_volume(Exec(threads), ct, preset, camera, kWidth, kHeight);
}

CtVolume air(const Grid& grid) {
  return test::fill_volume(grid, [](Vec3d) { return kAirHu; });
}

// Pixels that differ from the picture of air.
test::Found find_body(const Image& image, const Grid& grid, const Camera& camera) {
  const Image empty = draw(air(grid), camera);
  return test::find_pixels(
      image, [&](int x, int y) { return test::difference(image.at(x, y), empty.at(x, y)) > 60; });
}

// A ball covers the area of its silhouette.
TEST(VolumeView, BallCoversSilhouetteArea) {
  const Vec3d center{0.05, -0.02, 0.4};
  const std::vector<Grid> grids = {
      test::centered_grid({96, 96, 96}, {0.001, 0.001, 0.001}, center),
      test::centered_grid({110, 110, 55}, {0.001, 0.001, 0.002}, center, test::oblique_axes())};
  for (const Grid& grid : grids) {
    const CtVolume ct = test::ball_volume(grid, center, 0.035, 1000);
    for (const Vec3d from : {Vec3d{0, -0.3, 0}, {0.15, -0.2, 0.1}}) {
      const Camera camera{.eye = center + from, .target = center};
      const auto found = find_body(draw(ct, camera), grid, camera);
      const double expected = test::silhouette_area(camera, 0.035, kHeight);
      EXPECT_NEAR(found.count, expected, 0.02 * expected);
      EXPECT_NEAR(found.x, 0.5 * kWidth, 1);
      EXPECT_NEAR(found.y, 0.5 * kHeight, 1);
    }
  }
}

// A ball away from the center is drawn at its projected position.
TEST(VolumeView, OffCenterBallIsProjectedCorrectly) {
  const Grid grid = test::centered_grid({80, 90, 60}, {0.0015, 0.001, 0.002}, {}, test::oblique_axes());
  const Vec3d ball{0.012, 0.01, -0.015};
  const CtVolume ct = test::ball_volume(grid, ball, 0.012, 1000);
  for (const Vec3d eye : {Vec3d{0, -0.4, 0}, {0.4, 0, 0}, {-0.2, 0.2, 0.3}}) {
    const Camera camera{.eye = eye, .target = {}};
    const auto found = find_body(draw(ct, camera), grid, camera);
    const Vec3d expected = test::project(camera, ball, kWidth, kHeight);
    EXPECT_NEAR(found.x, expected.x, 1.5);
    EXPECT_NEAR(found.y, expected.y, 1.5);
  }
}

// One, two and eight threads draw the same picture.
TEST(VolumeView, IndependentOfThreadCount) {
  const Grid grid = test::centered_grid({80, 80, 60}, {0.001, 0.001, 0.001}, {}, test::oblique_axes());
  const CtVolume ct = test::ball_volume(grid, {0.005, 0, 0}, 0.025, 300);
  const Camera camera{.eye = {0.1, -0.2, 0.05}, .target = {}};
  for (const std::string& preset : volume_presets()) {
    const Image one = draw(ct, camera, preset.c_str(), 1);
    EXPECT_EQ(one.pixels, draw(ct, camera, preset.c_str(), 2).pixels) << preset;
    EXPECT_EQ(one.pixels, draw(ct, camera, preset.c_str(), 8).pixels) << preset;
  }
}

// The side towards the light is brighter.
TEST(VolumeView, LitSideIsBrighter) {
  const Grid grid = test::centered_grid({80, 80, 80}, {0.001, 0.001, 0.001}, {});
  const Image image = draw(test::ball_volume(grid, {}, 0.03, 1000), {.eye = {0, -0.3, 0}, .target = {}});
  const Rgb lit = image.at(kWidth / 2 - 30, kHeight / 2 - 30),
            away = image.at(kWidth / 2 + 30, kHeight / 2 + 30);
  EXPECT_GT(int(lit.r), int(away.r) + 40);
}

// Opaque tissue hides everything behind it.
TEST(VolumeView, OpaqueTissueHidesBackground) {
  const Grid grid = test::centered_grid({80, 80, 80}, {0.001, 0.001, 0.001}, {});
  const auto plate = [](Vec3d x) {
    return std::abs(x.y + 0.02) < 0.006 && norm(x) < 0.03 ? 1500.0 : -1000.0;
  };
  const auto both = [&plate](Vec3d x) { return x.y > 0.01 && norm(x) < 0.02 ? 150.0 : plate(x); };
  const Camera camera{.eye = {0, -0.3, 0}, .target = {}};
  const Image alone = draw(test::fill_volume(grid, plate), camera),
              with = draw(test::fill_volume(grid, both), camera);
  EXPECT_LE(test::difference(alone.at(kWidth / 2, kHeight / 2), with.at(kWidth / 2, kHeight / 2)), 3);
}

// Transmittance does not depend on the spacing of the samples.
TEST(VolumeView, TransmittanceIsIndependentOfSpacing) {
  const auto slab = [](Vec3d x) { return std::abs(x.y) < 0.01 ? 190.0 : -1000.0; };
  const auto red_of = [&](double spacing) {
    const int count = int(std::lround(0.08 / spacing));
    const Grid grid = test::centered_grid({count, count, count}, {spacing, spacing, spacing}, {});
    const Rgb c =
        draw(test::fill_volume(grid, slab), {.eye = {0.002, -0.3, 0.003}, .target = {}}, "soft tissue")
            .at(kWidth / 2, kHeight / 2);
    return int(c.r);
  };
  EXPECT_NEAR(red_of(0.001), red_of(0.0005), 12);
}

// An eye inside the volume, and volumes of one slice, are drawn.
TEST(VolumeView, DrawsFromInsideAndThinVolumes) {
  const Grid grid = test::centered_grid({40, 40, 40}, {0.001, 0.001, 0.001}, {});
  const CtVolume hollow = test::fill_volume(grid, [](Vec3d x) { return norm(x) > 0.01 ? 1000.0 : -1000.0; });
  const Image inside = draw(hollow, {.eye = {}, .target = {0, 1, 0}});
  EXPECT_GT(inside.at(kWidth / 2, kHeight / 2).r, 60);
  const Grid thin = test::centered_grid({40, 40, 1}, {0.001, 0.001, 0.001}, {});
  EXPECT_EQ(draw(air(thin), {.eye = {0, -0.3, 0}, .target = {}}).width, kWidth);
}

}  // namespace
}  // namespace turgor
