#include "turgor/view/transfer.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/view/color.hpp"

namespace turgor {

namespace {

// Tuned by eye on thorax and abdomen CTs.
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

Transfer::Transfer(std::span<const TransferPoint> points)
    : sums_(TransferView::kCount), most_(TransferView::kCount), visible_(TransferView::kCount + 1) {
  constexpr auto kCount = std::size_t(TransferView::kCount);
  Optical before;
  for (std::size_t i = 0; i < kCount; i++) {
    const Optical current = optical_at(points, float(int(i) + TransferView::kLow));
    most_[i] = current.extinction;
    visible_[i + 1] = visible_[i] + (current.extinction > 0);
    if (i > 0) {
      const double a = 0.5 * before.extinction, b = 0.5 * current.extinction;
      const OpticalSum& s = sums_[i - 1];
      sums_[i] = {s.extinction + a + b, s.r + a * before.color.x + b * current.color.x,
                  s.g + a * before.color.y + b * current.color.y,
                  s.b + a * before.color.z + b * current.color.z};
    }
    before = current;
  }
  for (std::size_t width = 1, row = 0; 2 * width <= kCount; width *= 2, row += kCount) {
    most_.resize(row + 2 * kCount);
    for (std::size_t i = 0; i + 2 * width <= kCount; i++)
      most_[row + kCount + i] = std::max(most_[row + i], most_[row + i + width]);
  }
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
