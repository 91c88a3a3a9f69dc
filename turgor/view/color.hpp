// Colours: from numbers to a perceptually even map, and between what screens store (sRGB bytes) and what
// light adds up in (linear). The map is a curve in Oklab (Ottosson 2020): lightness grows evenly, hue goes
// from indigo over teal to yellow.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {

/// Scalars to colours: `low` and `high` map to the ends of a perceptually even map.
struct ColorScale {
  float low = 0, high = 1;
  std::string label;  // for the legend, with unit: "displacement [mm]"
  float factor = 1;   // scalar · factor = the number the legend shows
};

/// The map at a fraction in [0, 1]; beyond the ends, the ends.
Rgb map_color(float fraction);
/// Where a scalar lies between the ends of its scale; 0.5 when the scale has no extent.
float scale_fraction(const ColorScale& scale, float scalar);

/// Linear light, 0…1 a component.
Vec3 linear_color(Rgb color);
/// Light above this is rolled off softly to white rather than cut.
constexpr float kShoulder = 0.75f;
TURGOR_HD inline float roll_off(float x) {
  return x <= kShoulder ? x : kShoulder + (1 - kShoulder) * std::tanh((x - kShoulder) / (1 - kShoulder));
}
TURGOR_HD inline std::uint8_t screen_byte(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  const float s = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}
TURGOR_HD inline Rgb screen_color(Vec3 linear) {
  return {screen_byte(roll_off(linear.x)), screen_byte(roll_off(linear.y)), screen_byte(roll_off(linear.z))};
}

/// The backdrop of pictures fades from here to its edges; linear.
constexpr Vec3 kBackdropCenter{0.050f, 0.064f, 0.082f}, kBackdropEdge{0.009f, 0.012f, 0.017f};
/// The backdrop at a place given in fractions of width and height from the top left; linear.
TURGOR_HD inline Vec3 backdrop(float x, float y) {
  constexpr Vec3 center = kBackdropCenter, edge = kBackdropEdge;
  const float dx = x - 0.5f, dy = y - 0.42f;
  const float distance = std::min(1.0f, 1.9f * (dx * dx + dy * dy));
  return center + (edge - center) * distance;
}

/// a + (b - a) · fraction, byte by byte.
Rgb mix(Rgb a, Rgb b, float fraction);

}  // namespace turgor
