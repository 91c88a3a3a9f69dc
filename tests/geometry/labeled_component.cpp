#include "turgor/geometry/labeled_component.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// A box of label 5 with a smaller one of label 200 in it, and a far voxel of label 5.
LabelVolume box_with_core() {
  LabelVolume labels{{.size = {12, 10, 8}, .spacing = {0.01, 0.01, 0.01}, .origin = {}, .axes = {}}, {}};
  labels.samples.resize(sample_count(labels.grid));
  for (int k = 2; k < 6; k++)
    for (int j = 2; j < 7; j++)
      for (int i = 2; i < 8; i++) labels.at(i, j, k) = i == 4 && j == 4 && k == 3 ? 200 : 5;
  labels.at(10, 8, 6) = 5;
  return labels;
}

TEST(LabeledPart, labels_are_joined_and_the_smaller_part_is_left_out_with_a_note) {
  const int wanted[] = {5, 200};
  const auto part = largest_labeled_part(box_with_core(), wanted);
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_NEAR(part->volume, 4 * 5 * 6 * 1e-6, 1e-12);
  ASSERT_EQ(part->notes.size(), 1u);
  EXPECT_NE(part->notes[0].find("1 smaller part with 1 mL left out"), std::string::npos) << part->notes[0];
}

TEST(LabeledPart, a_label_that_is_not_there_is_answered_with_those_that_are) {
  const int wanted[] = {7};
  const auto part = largest_labeled_part(box_with_core(), wanted);
  ASSERT_FALSE(part);
  EXPECT_EQ(part.error().message, "label 7 is not in the segmentation; it has 5 (120 mL), 200 (1 mL)");
}

TEST(LabeledPart, an_empty_segmentation_is_said_to_be_empty) {
  LabelVolume empty = box_with_core();
  std::fill(empty.samples.begin(), empty.samples.end(), std::uint16_t(0));
  const int wanted[] = {5};
  EXPECT_EQ(largest_labeled_part(empty, wanted).error().message,
            "label 5 is not in the segmentation; it has none at all");
}

TEST(LabeledPart, a_part_at_the_border_of_the_volume_is_noted_with_its_voxels) {
  LabelVolume labels = box_with_core();
  labels.at(10, 8, 6) = 0;
  for (int k = 6; k < 8; k++) labels.at(3, 3, k) = 5;
  const int wanted[] = {5};
  const auto part = largest_labeled_part(labels, wanted);
  ASSERT_TRUE(part);
  ASSERT_EQ(part->notes.size(), 1u);
  EXPECT_NE(part->notes[0].find("(1 voxel at the ends of k)"), std::string::npos) << part->notes[0];
}

}  // namespace
}  // namespace turgor
