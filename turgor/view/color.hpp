// Colours: from numbers to a perceptually even map, and between what screens store (sRGB bytes) and what
// light adds up in (linear). The map is a curve in Oklab (Ottosson 2020): lightness grows evenly, hue goes
// from indigo over teal to yellow.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/io/image.hpp"

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
Rgb screen_color(Vec3 linear);

/// The backdrop of pictures fades from here to its edges; linear.
constexpr Vec3 kBackdropCentre{0.050f, 0.064f, 0.082f}, kBackdropEdge{0.009f, 0.012f, 0.017f};
/// The backdrop at a place given in fractions of width and height from the top left; linear.
Vec3 backdrop(float x, float y);

/// a + (b - a) · fraction, byte by byte.
Rgb mix(Rgb a, Rgb b, float fraction);

}  // namespace turgor
