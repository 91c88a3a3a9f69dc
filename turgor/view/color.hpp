// Colors: a perceptually uniform color map, and conversion between sRGB bytes and linear light. The map is a
// curve in Oklab (Ottosson 2020): lightness grows uniformly, hue runs from indigo over teal to yellow.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {

/// Scalars to colors: `low` and `high` map to the ends of the color map.
struct ColorScale {
  float low = 0, high = 1;
  std::string label;  // for the legend, with unit: "displacement [mm]"
  float factor = 1;   // scalar · factor = number in the legend
};

/// Color map at a fraction in [0, 1], clamped.
Rgb map_color(float fraction);
/// Fraction of a scalar between the ends of its scale; 0.5 if the scale has no extent.
float scale_fraction(const ColorScale& scale, float scalar);

/// Linear light, each component 0…1.
Vec3 linear_color(Rgb color);
/// Light above this level rolls off smoothly to white instead of clipping.
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

/// The background of pictures fades from its center to its edges; linear.
constexpr Vec3 kBackdropCenter{0.050f, 0.064f, 0.082f}, kBackdropEdge{0.009f, 0.012f, 0.017f};
/// Background at a position in fractions of width and height from the top left; linear.
TURGOR_HD inline Vec3 backdrop(float x, float y) {
  constexpr Vec3 center = kBackdropCenter, edge = kBackdropEdge;
  const float dx = x - 0.5f, dy = y - 0.42f;
  const float distance = std::min(1.0f, 1.9f * (dx * dx + dy * dy));
  return center + (edge - center) * distance;
}

/// a + (b - a) · fraction, byte by byte.
Rgb mix(Rgb a, Rgb b, float fraction);

}  // namespace turgor
