#include "turgor/view/transfer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "turgor/view/color.hpp"

namespace turgor {

namespace {

// Our own numbers, tuned by eye on thorax and abdomen CTs.
constexpr TransferPoint kSkin[] = {
    {-420, 0.00f, {232, 190, 166}}, {-300, 0.25f, {232, 190, 166}}, {-120, 0.97f, {232, 184, 158}},
    {60, 0.98f, {214, 150, 126}},   {300, 0.99f, {232, 205, 180}},
};
constexpr TransferPoint kSoftTissue[] = {
    {-230, 0.000f, {244, 214, 150}}, {-120, 0.006f, {244, 214, 150}}, {-50, 0.008f, {240, 190, 130}},
    {0, 0.080f, {206, 104, 84}},     {50, 0.45f, {204, 96, 80}},      {100, 0.60f, {216, 120, 92}},
    {160, 0.75f, {234, 168, 128}},   {260, 0.90f, {244, 226, 196}},   {1500, 0.99f, {255, 252, 244}},
};
constexpr TransferPoint kMuscle[] = {
    {-25, 0.00f, {168, 62, 54}},    {15, 0.40f, {184, 76, 66}},    {60, 0.85f, {200, 96, 80}},
    {110, 0.92f, {216, 128, 102}},  {190, 0.95f, {234, 192, 158}}, {350, 0.98f, {246, 234, 210}},
    {1500, 0.99f, {255, 251, 242}},
};
constexpr TransferPoint kBone[] = {
    {110, 0.00f, {196, 132, 96}},  {170, 0.16f, {210, 158, 116}},  {240, 0.70f, {228, 198, 158}},
    {420, 0.95f, {240, 226, 198}}, {1200, 0.99f, {255, 250, 240}},
};
constexpr TransferPoint kLung[] = {
    {-945, 0.000f, {150, 176, 214}}, {-890, 0.018f, {176, 168, 196}}, {-820, 0.025f, {214, 160, 166}},
    {-720, 0.024f, {230, 150, 146}}, {-620, 0.014f, {232, 138, 124}}, {-540, 0.000f, {232, 138, 124}},
    {300, 0.000f, {236, 226, 206}},  {600, 0.030f, {236, 226, 206}},  {1300, 0.110f, {255, 250, 240}},
};

struct NamedPoints {
  const char* name;
  std::span<const TransferPoint> points;
};
constexpr NamedPoints kPresets[] = {
    {"skin", kSkin}, {"soft tissue", kSoftTissue}, {"muscle", kMuscle}, {"bone", kBone}, {"lung", kLung}};

float extinction_of(float opacity) { return -std::log(1 - std::min(opacity, 0.999f)) / 0.001f; }

Optical optical_at(std::span<const TransferPoint> points, float hu) {
  const auto optical = [](const TransferPoint& p) {
    return Optical{linear_color(p.color), extinction_of(p.opacity)};
  };
  if (hu <= points.front().hu) return optical(points.front());
  for (std::size_t i = 1; i < points.size(); i++) {
    if (hu > points[i].hu) continue;
    const Optical p = optical(points[i - 1]), q = optical(points[i]);
    const float f = (hu - points[i - 1].hu) / (points[i].hu - points[i - 1].hu);
    return {p.color + (q.color - p.color) * f, p.extinction + (q.extinction - p.extinction) * f};
  }
  return optical(points.back());
}

}  // namespace

std::size_t Transfer::entry(int hu) { return std::size_t(std::clamp(hu - kLow, 0, kCount - 1)); }

Transfer::Transfer(std::span<const TransferPoint> points)
    : extinction_(kCount), sums_(kCount), visible_(kCount + 1) {
  Optical before;
  for (std::size_t i = 0; i < kCount; i++) {
    const Optical here = optical_at(points, float(int(i) + kLow));
    extinction_[i] = here.extinction;
    visible_[i + 1] = visible_[i] + (here.extinction > 0);
    if (i > 0) {
      const double a = 0.5 * before.extinction, b = 0.5 * here.extinction;
      const Sum& s = sums_[i - 1];
      sums_[i] = {s.extinction + a + b, s.r + a * before.color.x + b * here.color.x,
                  s.g + a * before.color.y + b * here.color.y, s.b + a * before.color.z + b * here.color.z};
    }
    before = here;
  }
  most_.push_back(extinction_);
  for (std::size_t width = 1; 2 * width <= kCount; width *= 2) {
    std::vector<float> most(kCount - 2 * width + 1);
    for (std::size_t i = 0; i < most.size(); i++)
      most[i] = std::max(most_.back()[i], most_.back()[i + width]);
    most_.push_back(std::move(most));
  }
}

float Transfer::most_extinction(int low, int high) const {
  const std::size_t first = entry(low), count = entry(high) - first + 1;
  const auto row = std::size_t(std::bit_width(count) - 1);
  return std::max(most_[row][first], most_[row][first + count - (std::size_t(1) << row)]);
}

Transfer::Sum Transfer::sum_at(float hu) const {
  const float x = std::clamp(hu - float(kLow), 0.0f, float(kCount - 1));
  const auto i = std::min(std::size_t(x), std::size_t(kCount - 2));
  const double f = double(x) - double(i);
  const Sum &p = sums_[i], &q = sums_[i + 1];
  return {p.extinction + f * (q.extinction - p.extinction), p.r + f * (q.r - p.r), p.g + f * (q.g - p.g),
          p.b + f * (q.b - p.b)};
}

Optical Transfer::mean(float a, float b) const {
  if (!is_visible(int(std::min(a, b)) - 1, int(std::max(a, b)) + 1)) return {};
  constexpr float kLeast = 1;  // [HU] narrower ranges are widened: the tables hold no more detail
  const float middle = std::clamp(0.5f * (a + b), float(kLow) + kLeast, float(kLow + kCount - 1) - kLeast);
  const float half = std::max(0.5f * std::abs(b - a), 0.5f * kLeast);
  const Sum p = sum_at(middle - half), q = sum_at(middle + half);
  const double extinction = q.extinction - p.extinction;
  if (extinction <= 0) return {};
  return {{float((q.r - p.r) / extinction), float((q.g - p.g) / extinction), float((q.b - p.b) / extinction)},
          float(extinction / (2 * half))};
}

std::span<const TransferPoint> transfer_points(const std::string& preset) {
  for (const NamedPoints& known : kPresets)
    if (known.name == preset) return known.points;
  return {};
}

std::vector<std::string> volume_presets() {
  std::vector<std::string> names;
  for (const NamedPoints& known : kPresets) names.emplace_back(known.name);
  return names;
}

}  // namespace turgor
