#include "turgor/view/annotate.hpp"

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

bool is_inside(const PixelBox& box, int x, int y) {
  return x >= box.left && y >= box.top && x < box.right && y < box.bottom;
}

// Text changes pixels only inside the returned box.
TEST(Annotate, TextStaysInItsBox) {
  const Image before = make_image(300, 200, {40, 80, 120});
  for (const Align align : {Align::kLeft, Align::kCenter, Align::kRight}) {
    for (const bool halo : {false, true}) {
      Image after = before;
      const PixelBox box =
          draw_text(after, "wound gape 12.3 mm", 150, 100, {.size = 12, .align = align, .halo = halo});
      const auto changed = [&](int x, int y) { return after.at(x, y) != before.at(x, y); };
      EXPECT_GT(test::find_pixels(after, changed).count, 100);
      const auto strayed = [&](int x, int y) { return changed(x, y) && !is_inside(box, x, y); };
      EXPECT_EQ(test::find_pixels(after, strayed).count, 0);
    }
  }
}

// Text is left-aligned, centered or right-aligned at its anchor.
TEST(Annotate, TextIsAligned) {
  const auto middle = [](Align align) {
    Image image = make_image(400, 60);
    draw_text(image, "aligned", 200, 30, {.size = 20, .align = align});
    return test::find_pixels(image, [&](int x, int y) { return image.at(x, y).r > 100; });
  };
  EXPECT_GT(middle(Align::kLeft).x, 215);
  EXPECT_NEAR(middle(Align::kCenter).x, 200, 5);
  EXPECT_LT(middle(Align::kRight).x, 185);
  EXPECT_NEAR(middle(Align::kCenter).y, 30, 5);
}

// Text beyond the border of the image is clipped.
TEST(Annotate, TextIsClippedAtBorder) {
  Image image = make_image(20, 20);
  draw_text(image, "much too long for this picture", 10, 0, {.size = 30, .halo = true});
  EXPECT_EQ(image.pixels.size(), 400u);
}

// The ends of the legend have the end colors of the map.
TEST(Annotate, LegendShowsWholeColorMap) {
  Image image = make_image(640, 480, {90, 90, 90});
  const PixelBox bar =
      draw_legend(image, {.low = 0, .high = 0.0083f, .label = "displacement [mm]", .factor = 1000});
  const int x = (bar.left + bar.right) / 2;
  EXPECT_EQ(image.at(x, bar.top), map_color(1));
  EXPECT_EQ(image.at(x, bar.bottom - 1), map_color(0));
  EXPECT_EQ(image.at(x, (bar.top + bar.bottom) / 2),
            map_color(float(bar.bottom - 1 - (bar.top + bar.bottom) / 2) / float(bar.bottom - bar.top - 1)));
  EXPECT_EQ(image.at(10, 10), (Rgb{90, 90, 90}));
  EXPECT_LT(bar.right, image.width);
}

// A scale bar has a round length at the distance of the camera's target.
TEST(Annotate, ScaleBarIsRoundLengthAtTarget) {
  for (const double distance : {0.05, 0.37, 2.9, 40.0}) {
    const Camera camera{.eye = {0, -distance, 0}, .target = {0, 0, 0}, .up = {0, 0, 1}, .field_of_view = 40};
    Image image = make_image(800, 500);
    const PixelBox bar = draw_scale_bar(image, camera);
    const double meters_a_pixel = 2 * distance * std::tan(20 * 3.14159265358979 / 180) / 500;
    const double length = (bar.right - bar.left) * meters_a_pixel;
    const double power = std::pow(10, std::floor(std::log10(length * 1.02)));
    const double leading = length / power;
    EXPECT_TRUE(std::abs(leading - 1) < 0.03 || std::abs(leading - 2) < 0.06 || std::abs(leading - 5) < 0.15)
        << length;
    EXPECT_GT(bar.right - bar.left, 800 * 0.07) << distance;
    EXPECT_LE(bar.right - bar.left, 800 * 0.2 + 1) << distance;
  }
}

// The second legend is drawn to the left of the first.
TEST(Annotate, SecondLegendIsBesideFirst) {
  Image image = make_image(900, 480);
  const ColorScale scale{.low = -1, .high = 1, .label = "strain", .factor = 1};
  const PixelBox first = draw_legend(image, scale, 0), second = draw_legend(image, scale, 1);
  EXPECT_LT(second.right, first.left);
}

// A legend with an empty, NaN or huge range does not crash.
TEST(Annotate, InvalidScaleIsHarmless) {
  Image image = make_image(200, 100);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  draw_legend(image, {.low = 1, .high = 1, .label = "constant", .factor = 1});
  draw_legend(image, {.low = nan, .high = nan, .label = "nothing", .factor = 1});
  draw_legend(image, {.low = 0, .high = 1e30f, .label = "much", .factor = 1});
  SUCCEED();
}

// Pictures are arranged side by side below their captions.
TEST(Annotate, PicturesAreArrangedWithCaptions) {
  const Image red = make_image(80, 60, {255, 0, 0}), blue = make_image(50, 40, {0, 0, 255});
  const Image row = side_by_side({red, blue}, {"before", "after"});
  EXPECT_GE(row.width, 130);
  EXPECT_GT(row.height, 60);
  const auto count = [&row](Rgb color) {
    return test::find_pixels(row, [&](int x, int y) { return row.at(x, y) == color; });
  };
  EXPECT_EQ(count({255, 0, 0}).count, 80 * 60);
  EXPECT_EQ(count({0, 0, 255}).count, 50 * 40);
  EXPECT_LT(count({255, 0, 0}).x, count({0, 0, 255}).x);
  const int band = row.height - 60;
  const auto letters = test::find_pixels(row, [&](int x, int y) { return y < band && row.at(x, y).r > 128; });
  EXPECT_GT(letters.count, 20);
}

// An arrangement of no pictures is an empty picture.
TEST(Annotate, NoPicturesGiveEmptyPicture) { EXPECT_EQ(side_by_side({}, {}).width, 0); }

// Names of one color share a row, and a name is listed once.
TEST(Annotate, NamesOfOneColorShareRow) {
  std::vector<NameRow> rows;
  for (const char* name : {"liver", "stomach", "liver"}) add_name({158, 68, 56}, name, rows);
  add_name({236, 214, 150}, "live", rows);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].names, "liver, stomach");
  EXPECT_EQ(rows[1].names, "live");
}

// The list of names stays in its panel, has a swatch of each color, and cuts names that are too long.
TEST(Annotate, NamesStayInTheirPanel) {
  const Rgb flesh{158, 68, 56}, nodule{10, 214, 150};
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(1920, 1080), std::pair(200, 150)}) {
    const Image before = make_image(width, height, {40, 80, 120});
    Image after = before;
    const PixelBox panel = draw_names(after, {{flesh, "liver"}, {nodule, std::string(300, 'n')}});
    EXPECT_LE(panel.right, 0.6 * width);
    EXPECT_LT(panel.bottom, height / 2);
    const auto strayed = [&](int x, int y) {
      return after.at(x, y) != before.at(x, y) && !is_inside(panel, x, y);
    };
    EXPECT_EQ(test::find_pixels(after, strayed).count, 0);
    for (const Rgb color : {flesh, nodule})
      EXPECT_GT(test::find_pixels(after, [&](int x, int y) { return after.at(x, y) == color; }).count, 60);
  }
  Image empty = make_image(64, 64);
  EXPECT_EQ(draw_names(empty, {}).right, 0);
}

}  // namespace
}  // namespace turgor
