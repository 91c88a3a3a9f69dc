// What each Hounsfield value looks like in volume rendering: colour, and how strongly it absorbs. Tables hold
// the integrals over the values, so that a ray gets the mean over all values between two samples and thin
// surfaces show no rings [Engel, Kraus, Ertl 2001, without self-absorption inside a segment].
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/io/image.hpp"

namespace turgor {

/// Between two points everything changes linearly; beyond the ends it stays.
struct TransferPoint {
  float hu;
  float opacity;  // of one millimetre, 0…1
  Rgb color;
};

/// Emission and absorption of a place in a volume.
struct Optical {
  Vec3 color;            // linear, 0…1
  float extinction = 0;  // [1/m]
};

class Transfer {
 public:
  explicit Transfer(std::span<const TransferPoint> points);

  /// The mean over the values from `a` to `b`.
  Optical mean(float a, float b) const;
  /// Whether some value in [low, high] absorbs.
  bool is_visible(int low, int high) const { return visible_[entry(high) + 1] > visible_[entry(low)]; }
  /// The strongest absorption of any value in [low, high] [1/m].
  float most_extinction(int low, int high) const;
  float extinction(int hu) const { return extinction_[entry(hu)]; }

 private:
  static constexpr int kLow = -1024, kCount = 4096;  // table entries, one a Hounsfield unit
  static std::size_t entry(int hu);

  struct Sum {
    double extinction = 0, r = 0, g = 0, b = 0;
  };
  Sum sum_at(float hu) const;

  std::vector<float> extinction_;         // at each entry [1/m]
  std::vector<Sum> sums_;                 // integrals from the first entry up to each
  std::vector<std::vector<float>> most_;  // row r: the largest of 2^r entries from each on
  std::vector<int> visible_;              // absorbing entries before each
};

/// The points of a tissue preset; empty when there is none of this name.
std::span<const TransferPoint> transfer_points(const std::string& preset);

/// Tissue presets of volume rendering: "skin", "soft tissue", "muscle", "bone", "lung".
std::vector<std::string> volume_presets();

}  // namespace turgor
