// What a segmentation says about a CT: how large each labelled part is, where, and how dense.
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

/// One measure a label that occurs, by rising number, without the background (0). `ct` may be null, or must
/// have the labels' grid.
std::vector<LabelMeasure> measure_labels(const LabelVolume& labels, const CtVolume* ct);

/// How many samples of a CT are of which kind.
struct HuSummary {
  int lowest = 0, highest = 0;                  // [HU]
  double mean = 0;                              // [HU]
  double air = 0, fat = 0, soft = 0, bone = 0;  // fractions; see the bounds below
};
constexpr int kAirBelow = -449, kFatBelow = -30, kBoneFrom = 200;  // where a lattice bins them, too [HU]
HuSummary summarize(const CtVolume& ct);

}  // namespace turgor
