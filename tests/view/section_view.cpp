#include "turgor/view/section_view.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

constexpr Window kWindow{2000, 0};
constexpr Plane kPlanes[] = {Plane::kAxial, Plane::kCoronal, Plane::kSagittal};

bool is_letter(Rgb c) { return c.r > 150 && c.b < 160 && c.r - c.b > 60; }

std::vector<Grid> grids() {
  const Vec3d center{0.02, -0.05, 0.7};
  return {
      test::centered_grid({90, 80, 70}, {0.001, 0.001, 0.001}, center),
      test::centered_grid({90, 80, 40}, {0.001, 0.0012, 0.002}, center, {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}),
      test::centered_grid({100, 90, 50}, {0.001, 0.001, 0.002}, center, test::oblique_axes())};
}

// Directions to the right and downwards in each plane, in the patient's frame.
Vec3d right_of(Plane plane) { return plane == Plane::kSagittal ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}; }
Vec3d below(Plane plane) { return plane == Plane::kAxial ? Vec3d{0, 1, 0} : Vec3d{0, 0, -1}; }

// A bright ball is at its position in every plane of flipped and oblique volumes.
TEST(SectionView, BallIsAtItsPositionInEveryPlane) {
  for (const Grid& grid : grids()) {
    const Box box = bounding_box(grid);
    const Vec3d middle = (box.low + box.high) * 0.5, ball = middle + Vec3d{0.010, 0.006, -0.008};
    const CtVolume ct = test::ball_volume(grid, ball, 0.005, 1000);
    for (const Plane plane : kPlanes) {
      const Image image = draw_section(ct, plane, ball, kWindow, 300);
      const double pixel = section_frame(grid, plane, ball, 300).pixel;
      const auto found = test::find_pixels(image, [&](int x, int y) {
        const Rgb c = image.at(x, y);
        return c.r > 128 && c.r == c.g && c.g == c.b && y < 250;  // excludes letters and scale bar
      });
      EXPECT_NEAR(found.x, 0.5 * image.width + dot(ball - middle, right_of(plane)) / pixel, 1.5);
      EXPECT_NEAR(found.y, 0.5 * image.height + dot(ball - middle, below(plane)) / pixel, 1.5);
      EXPECT_NEAR(found.count, std::numbers::pi * std::pow(0.005 / pixel, 2), 0.06 * found.count);
    }
  }
}

// The patient's right is on the left; front and head are up.
TEST(SectionView, RadiologicalOrientation) {
  const SectionFrame axial = section_frame(grids()[0], Plane::kAxial, {}, 100);
  EXPECT_EQ(axial.right, (Vec3d{1, 0, 0}));  // LPS: +x is the patient's left
  EXPECT_EQ(axial.down, (Vec3d{0, 1, 0}));
  const SectionFrame sagittal = section_frame(grids()[0], Plane::kSagittal, {}, 100);
  EXPECT_EQ(sagittal.right, (Vec3d{0, 1, 0}));
  EXPECT_EQ(sagittal.down, (Vec3d{0, 0, -1}));
}

// The picture has the aspect ratio of the volume.
TEST(SectionView, PictureKeepsAspectRatio) {
  const Grid grid = test::centered_grid({100, 50, 40}, {0.001, 0.001, 0.005}, {});
  const Image coronal =
      draw_section(test::fill_volume(grid, [](Vec3d) { return 0; }), Plane::kCoronal, {}, {}, 400);
  EXPECT_EQ(coronal.height, 400);
  EXPECT_EQ(coronal.width, 200);
}

// Orientation letters are at the four sides and not in the middle.
TEST(SectionView, OrientationLettersAtFourSides) {
  const CtVolume ct = test::fill_volume(grids()[0], [](Vec3d) { return -1000; });
  for (const Plane plane : kPlanes) {
    const Image image = draw_section(ct, plane, bounding_box(ct.grid).low, {}, 400);
    const auto count_in = [&](double x0, double x1, double y0, double y1) {
      return test::find_pixels(image,
                               [&](int x, int y) {
                                 const double u = double(x) / image.width, v = double(y) / image.height;
                                 return u >= x0 && u < x1 && v >= y0 && v < y1 && is_letter(image.at(x, y));
                               })
          .count;
    };
    EXPECT_GT(count_in(0, 0.1, 0.4, 0.6), 10);
    EXPECT_GT(count_in(0.9, 1, 0.4, 0.6), 10);
    EXPECT_GT(count_in(0.4, 0.6, 0, 0.1), 10);
    EXPECT_GT(count_in(0.4, 0.6, 0.9, 1), 10);
    EXPECT_EQ(count_in(0.2, 0.8, 0.2, 0.8), 0);
  }
}

// Gray values follow center and width of the window.
TEST(SectionView, GrayValuesFollowWindow) {
  const Grid grid = test::centered_grid({64, 64, 64}, {0.001, 0.001, 0.001}, {});
  const auto gray_of = [&grid](int hu, Window window) {
    const CtVolume ct = test::fill_volume(grid, [hu](Vec3d) { return hu; });
    return draw_section(ct, Plane::kAxial, {}, window, 200).at(100, 70).r;
  };
  EXPECT_EQ(gray_of(-200, {400, 0}), 0);
  EXPECT_EQ(gray_of(200, {400, 0}), 255);
  EXPECT_NEAR(gray_of(40, {350, 40}), 128, 1);
  EXPECT_NEAR(gray_of(100, {400, 0}), 191, 1);
}

// The scale bar has the stated length.
TEST(SectionView, ScaleBarHasStatedLength) {
  const Grid grid = test::centered_grid({100, 100, 100}, {0.003, 0.003, 0.003},
                                        {});  // 30 cm wide: a bar of 5 cm fits into a quarter
  const Image image =
      draw_section(test::fill_volume(grid, [](Vec3d) { return -1000; }), Plane::kAxial, {}, {}, 600);
  int longest = 0;
  for (int y = 500; y < 600; y++) {
    int run = 0;
    for (int x = 0; x < 300; x++) {
      run = image.at(x, y).r > 200 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_EQ(longest, 100);  // 600 pixels are 30 cm
}

// Volumes with one slice and planes outside of the volume are drawn.
TEST(SectionView, DrawsSingleSliceAndOutsidePlanes) {
  const Grid grid = test::centered_grid({64, 48, 1}, {0.001, 0.001, 0.005}, {});
  const CtVolume ct = test::fill_volume(grid, [](Vec3d) { return 500; });
  EXPECT_EQ(draw_section(ct, Plane::kAxial, {}, {}, 96).at(64, 30), (Rgb{255, 255, 255}));
  EXPECT_EQ(draw_section(ct, Plane::kCoronal, {}, {}, 96).height, 96);
  EXPECT_EQ(draw_section(ct, Plane::kAxial, {0, 0, 1}, {}, 96).at(64, 30), Rgb{});
}

// An unknown window preset is an error that lists the known ones.
TEST(SectionView, UnknownWindowListsKnown) {
  EXPECT_TRUE(window_preset("lung"));
  const Result<Window> unknown = window_preset("lungs");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("\"abdomen\", \"bone\", \"lung\""), std::string::npos);
}

}  // namespace
}  // namespace turgor
