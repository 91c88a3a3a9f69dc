#include "turgor/geometry/label_measures.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

struct LabelSums {
  std::int64_t voxels = 0, i = 0, j = 0, k = 0, hu = 0;
};

}  // namespace

std::vector<LabelMeasure> measure_labels(const LabelVolume& labels, const CtVolume* ct) {
  TURGOR_ASSERT(!ct || ct->samples.size() == labels.samples.size(), "labels and CT have one grid");
  // sums by label
  std::vector<LabelSums> sums(65536);
  std::size_t at = 0;
  const Int3 size = labels.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++, at++) {
        if (labels.samples[at] == 0) continue;
        LabelSums& s = sums[labels.samples[at]];
        s.voxels++, s.i += i, s.j += j, s.k += k;
        if (ct) s.hu += ct->samples[at];
      }
  // means of the labels that occur
  std::vector<LabelMeasure> measures;
  for (int label = 1; label < 65536; label++) {
    const LabelSums& s = sums[std::size_t(label)];
    if (s.voxels == 0) continue;
    const double n = double(s.voxels);
    measures.push_back(
        {.label = label,
         .voxels = std::size_t(s.voxels),
         .volume = n * sample_volume(labels.grid),
         .centroid = point_at(labels.grid, {double(s.i) / n, double(s.j) / n, double(s.k) / n}),
         .mean_hu = double(s.hu) / n});
  }
  return measures;
}

HuSummary summarize(const CtVolume& ct) {
  if (ct.samples.empty()) return {};
  std::vector<std::size_t> histogram(65536);
  for (const std::int16_t hu : ct.samples) histogram[std::size_t(hu + 32768)]++;
  HuSummary summary{.lowest = 32767, .highest = -32768};
  const double share = 1 / double(ct.samples.size());
  for (int hu = -32768; hu <= 32767; hu++) {
    const double fraction = double(histogram[std::size_t(hu + 32768)]) * share;
    if (fraction == 0) continue;
    summary.lowest = std::min(summary.lowest, hu);
    summary.highest = std::max(summary.highest, hu);
    summary.mean += fraction * hu;
    (hu < kAirBelow   ? summary.air
     : hu < kFatBelow ? summary.fat
     : hu < kBoneFrom ? summary.soft
                      : summary.bone) += fraction;
  }
  return summary;
}

}  // namespace turgor
