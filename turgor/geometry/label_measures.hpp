// Measures of a segmentation and its CT: volume, centroid and mean density of each label.
#pragma once

#include <vector>

#include "turgor/geometry/volume.hpp"

namespace turgor {

struct LabelMeasure {
  int label = 0;
  std::size_t voxels = 0;
  double volume = 0;   // [m³]
  Vec3d centroid;      // LPS [m]
  double mean_hu = 0;  // [HU]
};

/// One measure per label that occurs, in ascending order, without the background (0). `ct` may be null, or
/// must have the labels' grid.
std::vector<LabelMeasure> measure_labels(const LabelVolume& labels, const CtVolume* ct);

/// Composition of a CT by density.
struct HuSummary {
  int lowest = 0, highest = 0;                  // [HU]
  double mean = 0;                              // [HU]
  double air = 0, fat = 0, soft = 0, bone = 0;  // fractions; see the bounds below
};
constexpr int kAirBelow = -449, kFatBelow = -30,
              kBoneFrom = 200;  // as in the classification of a lattice body [HU]
HuSummary summarize(const CtVolume& ct);

}  // namespace turgor
