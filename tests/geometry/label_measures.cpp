#include "turgor/geometry/label_measures.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// A box has its exact voxel count, volume, centroid and mean HU.
TEST(LabelMeasures, BoxVolumeCentroidAndMean) {
  LabelVolume labels{
      {.size = {10, 8, 6}, .spacing = {1e-3, 2e-3, 3e-3}, .origin = {0.1, 0.2, 0.3}, .axes = {}}, {}};
  labels.samples.resize(480);
  CtVolume ct{labels.grid, std::vector<std::int16_t>(480, -1000)};
  for (int k = 1; k < 4; k++)
    for (int j = 2; j < 6; j++)
      for (int i = 3; i < 8; i++) {
        labels.at(i, j, k) = 7;
        ct.at(i, j, k) = std::int16_t(10 * i);
      }
  const auto measures = measure_labels(labels, &ct);
  ASSERT_EQ(measures.size(), 1u);
  EXPECT_EQ(measures[0].label, 7);
  EXPECT_EQ(measures[0].voxels, 60u);
  EXPECT_NEAR(measures[0].volume, 60 * 6e-9, 1e-15);
  EXPECT_NEAR(norm(measures[0].centroid - Vec3d{0.105, 0.207, 0.306}), 0, 1e-12);
  EXPECT_NEAR(measures[0].mean_hu, 50, 1e-12);
}

// A summary has the fractions of air, fat, soft tissue and bone.
TEST(LabelMeasures, SummaryCountsTissueFractions) {
  const CtVolume ct{{.size = {4, 2, 1}, .spacing = {1, 1, 1}, .origin = {}, .axes = {}},
                    {-1000, -450, -449, -100, -30, 0, 199, 200}};
  const HuSummary hu = summarize(ct);
  EXPECT_EQ(hu.lowest, -1000);
  EXPECT_EQ(hu.highest, 200);
  EXPECT_DOUBLE_EQ(hu.air, 0.25);
  EXPECT_DOUBLE_EQ(hu.fat, 0.25);
  EXPECT_DOUBLE_EQ(hu.soft, 0.375);
  EXPECT_DOUBLE_EQ(hu.bone, 0.125);
}

}  // namespace
}  // namespace turgor
