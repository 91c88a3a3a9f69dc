#include <algorithm>

#include <gtest/gtest.h>

#include "turgor/sim/bodies/lattice/crop_to_label.hpp"

namespace turgor {
namespace {

/// 20×16×12 voxels of 2 mm at 40 HU, slightly rotated and far from the origin.
CtVolume full_ct() {
  CtVolume ct;
  ct.grid.size = {20, 16, 12};
  ct.grid.spacing = {0.002, 0.002, 0.002};
  ct.grid.origin = {0.1, -0.3, 0.7};
  ct.grid.axes = {{{0.8, 0.6, 0}, {-0.6, 0.8, 0}, {0, 0, 1}}};
  ct.samples.assign(sample_count(ct.grid), 40);
  return ct;
}

/// Label 5 in a box, and in one separate voxel.
LabelVolume box_labels(const Grid& grid, Int3 low, Int3 high) {
  LabelVolume labels;
  labels.grid = grid;
  labels.samples.assign(sample_count(grid), 0);
  for (int k = low.z; k < high.z; k++)
    for (int j = low.y; j < high.y; j++)
      for (int i = low.x; i < high.x; i++) labels.samples[sample_index(grid, i, j, k)] = 5;
  labels.samples[0] = 5;
  return labels;
}

long tissue_voxels(const CtVolume& ct) {
  return std::count(ct.samples.begin(), ct.samples.end(), std::int16_t(40));
}

// The largest component remains in air at its position in the patient; a separate voxel is noted.
TEST(KeepLabel, KeepsLargestComponentInPlace) {
  CtVolume ct = full_ct();
  const Grid before = ct.grid;
  std::vector<std::string> notes;
  ASSERT_TRUE(crop_to_label(Exec(2), box_labels(ct.grid, {8, 5, 4}, {13, 9, 7}), 5, {2, 2, 2}, ct, notes));
  EXPECT_EQ(ct.grid.size, (Int3{9, 8, 7}));
  EXPECT_EQ(tissue_voxels(ct), 5 * 4 * 3);
  EXPECT_EQ(ct.at(2, 2, 2), 40);
  EXPECT_EQ(ct.at(1, 2, 2), kAirHu);
  EXPECT_LT(norm(point_at(ct.grid, {2, 2, 2}) - point_at(before, {8, 5, 4})), 1e-12) << "m";
  EXPECT_EQ(notes.size(), 1u) << "the separate voxel";
}

// An enclosed tumor of another label keeps its CT values.
TEST(KeepLabel, EnclosedLabelStays) {
  CtVolume ct = full_ct();
  LabelVolume labels = box_labels(ct.grid, {8, 5, 4}, {13, 9, 7});
  labels.at(10, 7, 5) = 77;
  std::vector<std::string> notes;
  ASSERT_TRUE(crop_to_label(Exec(1), labels, 5, {0, 0, 0}, ct, notes));
  EXPECT_EQ(tissue_voxels(ct), 5 * 4 * 3);
  EXPECT_EQ(ct.at(2, 2, 1), 40);
}

// Labels on another grid select voxels by their position.
TEST(KeepLabel, AcceptsLabelsOnOtherGrid) {
  CtVolume ct = full_ct();
  Grid fine = ct.grid;  // half the spacing, from half a voxel earlier: the same box of the patient
  fine.size = fine.size * 2;
  fine.spacing = fine.spacing * 0.5;
  fine.origin = point_at(ct.grid, {-0.25, -0.25, -0.25});
  std::vector<std::string> notes;
  ASSERT_TRUE(crop_to_label(Exec(1), box_labels(fine, {16, 10, 8}, {26, 18, 14}), 5, {0, 0, 0}, ct, notes));
  EXPECT_EQ(ct.grid.size, (Int3{5, 4, 3}));
  EXPECT_EQ(tissue_voxels(ct), 5 * 4 * 3);
}

// Missing labels and labels outside of the CT are errors.
TEST(KeepLabel, ReportsErrors) {
  CtVolume ct = full_ct();
  std::vector<std::string> notes;
  const LabelVolume labels = box_labels(ct.grid, {8, 5, 4}, {13, 9, 7});
  EXPECT_NE(crop_to_label(Exec(1), labels, 7, {}, ct, notes)
                .error()
                .message.find("label 7 is not in the segmentation"),
            std::string::npos);
  LabelVolume outside = labels;
  outside.grid.origin = {9, 9, 9};
  EXPECT_NE(crop_to_label(Exec(1), outside, 5, {}, ct, notes).error().message.find("lies outside the CT"),
            std::string::npos);
}

}  // namespace
}  // namespace turgor
