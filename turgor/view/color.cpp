#include "turgor/view/color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace turgor {

namespace {

constexpr int kMapSize = 256;

struct Oklab {
  double lightness, a, b;
};

// The color curve: linear in lightness; the a and b components follow a cubic Bézier curve inside the sRGB
// gamut.
Oklab map_curve(double t) {
  constexpr double kA[] = {0.055, 0.0, -0.19, -0.035}, kB[] = {-0.115, -0.13, -0.01, 0.17};
  const double u = 1 - t, weights[] = {u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t};
  Oklab color{0.30 + 0.62 * t, 0, 0};
  for (int i = 0; i < 4; i++) color.a += weights[i] * kA[i], color.b += weights[i] * kB[i];
  return color;
}

Vec3 linear_of(const Oklab& c) {
  const auto cubed = [](double x) { return x * x * x; };
  const double l = cubed(c.lightness + 0.3963377774 * c.a + 0.2158037573 * c.b);
  const double m = cubed(c.lightness - 0.1055613458 * c.a - 0.0638541728 * c.b);
  const double s = cubed(c.lightness - 0.0894841775 * c.a - 1.2914855480 * c.b);
  return {float(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          float(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          float(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

// Samples of the curve at equal arc length, so that equal steps of the scalar look equally large.
std::array<Rgb, kMapSize> build_map() {
  constexpr int kFine = 4096;
  std::vector<double> length(kFine + 1, 0.0);
  for (int i = 1; i <= kFine; i++) {
    const Oklab p = map_curve((i - 1.0) / kFine), q = map_curve(double(i) / kFine);
    length[std::size_t(i)] =
        length[std::size_t(i) - 1] + std::hypot(q.lightness - p.lightness, q.a - p.a, q.b - p.b);
  }
  std::array<Rgb, kMapSize> map;
  std::size_t at = 0;
  for (int i = 0; i < kMapSize; i++) {
    while (at < kFine && length[at] < length[kFine] * i / (kMapSize - 1)) at++;
    const Vec3 color = linear_of(map_curve(double(at) / kFine));
    map[std::size_t(i)] = {screen_byte(color.x), screen_byte(color.y), screen_byte(color.z)};
  }
  return map;
}

float decode(std::uint8_t byte) {
  const float s = float(byte) / 255;
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Rgb map_color(float fraction) {
  static const std::array<Rgb, kMapSize> map = build_map();
  return map[std::size_t(std::lround((kMapSize - 1) * std::clamp(fraction, 0.0f, 1.0f)))];
}

float scale_fraction(const ColorScale& scale, float scalar) {
  return scale.high == scale.low ? 0.5f : (scalar - scale.low) / (scale.high - scale.low);
}

Vec3 linear_color(Rgb color) { return {decode(color.r), decode(color.g), decode(color.b)}; }

Rgb mix(Rgb a, Rgb b, float fraction) {
  const auto byte = [fraction](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(float(from) + (float(to) - float(from)) * fraction));
  };
  return {byte(a.r, b.r), byte(a.g, b.g), byte(a.b, b.b)};
}

}  // namespace turgor
