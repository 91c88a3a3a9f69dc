// Transfer function of volume rendering: color and absorption by Hounsfield value. Tables hold the integrals
// over the values (preintegration), so that a ray uses the mean over all values between two samples and thin
// surfaces show no rings [Engel, Kraus, Ertl 2001, without self-absorption inside a segment].
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {

/// Linear between points, constant beyond the ends.
struct TransferPoint {
  float hu;
  float opacity;  // of one millimeter, 0…1
  Rgb color;
};

/// Emission and absorption at a point of a volume.
struct Optical {
  Vec3 color;            // linear, 0…1
  float extinction = 0;  // [1/m]
};

struct OpticalSum {
  double extinction = 0, r = 0, g = 0, b = 0;
};

/// Tables of a transfer function in host or device memory.
struct TransferView {
  static constexpr int kLow = -1024, kCount = 4096;  // table entries, one per Hounsfield unit

  const OpticalSum* sums;  // integrals from the first entry to each
  const float* most;       // row r: maximum of 2^r entries starting at each; row 0: each [1/m]
  const int* visible;      // absorbing entries before each

  TURGOR_HD static std::size_t entry(int hu) { return std::size_t(std::clamp(hu - kLow, 0, kCount - 1)); }
  TURGOR_HD float extinction(int hu) const { return most[entry(hu)]; }
  TURGOR_HD bool is_visible(int low, int high) const {
    return visible[entry(high) + 1] > visible[entry(low)];
  }
  TURGOR_HD float most_extinction(int low, int high) const {
    const std::size_t first = entry(low), count = entry(high) - first + 1;
    std::size_t row = 0;
    while (std::size_t(2) << row <= count) row++;
    const float* of_row = most + row * std::size_t(kCount);
    return std::max(of_row[first], of_row[first + count - (std::size_t(1) << row)]);
  }
  TURGOR_HD Optical mean(float a, float b) const {
    if (!is_visible(int(std::min(a, b)) - 1, int(std::max(a, b)) + 1)) return {};
    constexpr float kLeast = 1;  // [HU] narrower ranges are widened to the resolution of the tables
    const float middle = std::clamp(0.5f * (a + b), float(kLow) + kLeast, float(kLow + kCount - 1) - kLeast);
    const float half = std::max(0.5f * std::abs(b - a), 0.5f * kLeast);
    const OpticalSum p = sum_at(middle - half), q = sum_at(middle + half);
    const double extinction = q.extinction - p.extinction;
    if (extinction <= 0) return {};
    return {
        {float((q.r - p.r) / extinction), float((q.g - p.g) / extinction), float((q.b - p.b) / extinction)},
        float(extinction / (2 * half))};
  }

 private:
  TURGOR_HD OpticalSum sum_at(float hu) const {
    const float x = std::clamp(hu - float(kLow), 0.0f, float(kCount - 1));
    const auto i = std::min(std::size_t(x), std::size_t(kCount - 2));
    const double f = double(x) - double(i);
    const OpticalSum &p = sums[i], &q = sums[i + 1];
    return {p.extinction + f * (q.extinction - p.extinction), p.r + f * (q.r - p.r), p.g + f * (q.g - p.g),
            p.b + f * (q.b - p.b)};
  }
};

class Transfer {
 public:
  explicit Transfer(std::span<const TransferPoint> points);

  /// Mean over the values from `a` to `b`.
  Optical mean(float a, float b) const { return view().mean(a, b); }
  /// True if some value in [low, high] absorbs.
  bool is_visible(int low, int high) const { return view().is_visible(low, high); }
  /// Strongest absorption of any value in [low, high] [1/m].
  float most_extinction(int low, int high) const { return view().most_extinction(low, high); }
  float extinction(int hu) const { return view().extinction(hu); }

  TransferView view() const { return {sums_.data(), most_.data(), visible_.data()}; }
  // tables for copying
  const std::vector<OpticalSum>& sums() const { return sums_; }
  const std::vector<float>& most() const { return most_; }
  const std::vector<int>& visible() const { return visible_; }

 private:
  std::vector<OpticalSum> sums_;
  std::vector<float> most_;
  std::vector<int> visible_;
};

/// Points of a tissue preset; empty for an unknown name.
std::span<const TransferPoint> transfer_points(const std::string& preset);

/// Tissue presets of volume rendering: "skin", "soft tissue", "muscle", "bone", "lung".
std::vector<std::string> volume_presets();

}  // namespace turgor
