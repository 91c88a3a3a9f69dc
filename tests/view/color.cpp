#include "turgor/view/color.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Forward Oklab transform [Ottosson 2020], independent of the inverse that builds the map.
Vec3d oklab(Rgb color) {
  const Vec3d c(linear_color(color));
  const double l = std::cbrt(0.4122214708 * c.x + 0.5363325363 * c.y + 0.0514459929 * c.z);
  const double m = std::cbrt(0.2119034982 * c.x + 0.6806995451 * c.y + 0.1073969566 * c.z);
  const double s = std::cbrt(0.0883024619 * c.x + 0.2817188376 * c.y + 0.6299787005 * c.z);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

// Lightness of the color map increases in perceptually equal steps.
TEST(Color, MapIsPerceptuallyUniform) {
  constexpr int kSteps = 16;
  double least = 1e9, most = 0;
  for (int i = 0; i < kSteps; i++) {
    const Vec3d a = oklab(map_color(float(i) / kSteps)), b = oklab(map_color(float(i + 1) / kSteps));
    EXPECT_GT(b.x, a.x) << "lightness at step " << i;
    least = std::min(least, norm(b - a));
    most = std::max(most, norm(b - a));
  }
  EXPECT_LT(most / least, 1.12);
}

// Values outside of the range get the end colors of the map.
TEST(Color, MapClampsAtEnds) {
  EXPECT_EQ(map_color(-3), map_color(0));
  EXPECT_EQ(map_color(7), map_color(1));
  EXPECT_NE(map_color(0), map_color(1));
}

// The screen color inverts the linear color, except for highlights that are compressed.
TEST(Color, ScreenColorInvertsLinearColor) {
  for (int byte = 0; byte < 215; byte += 5) {  // brighter light is compressed
    const Rgb color{std::uint8_t(byte), std::uint8_t(byte / 2), std::uint8_t(214 - byte)};
    EXPECT_EQ(screen_color(linear_color(color)), color);
  }
  EXPECT_GT(screen_color({3, 3, 3}).r, 250);
}

// A scale with an empty range maps to its middle.
TEST(Color, EmptyScaleMapsToMiddle) {
  EXPECT_EQ(scale_fraction({.low = 2, .high = 2, .label = {}, .factor = 1}, 2), 0.5f);
  EXPECT_EQ(scale_fraction({.low = 2, .high = 4, .label = {}, .factor = 1}, 3.5f), 0.75f);
}

}  // namespace
}  // namespace turgor
