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

// Labels are joined; the smaller component is dropped and noted.
TEST(LabeledComponent, KeepsLargestComponentWithNote) {
  const int wanted[] = {5, 200};
  const auto component = largest_labeled_component(box_with_core(), wanted);
  ASSERT_TRUE(component) << component.error().message;
  EXPECT_NEAR(component->volume, 4 * 5 * 6 * 1e-6, 1e-12);
  ASSERT_EQ(component->notes.size(), 1u);
  EXPECT_NE(component->notes[0].find("1 smaller component with 1 mL ignored"), std::string::npos)
      << component->notes[0];
}

// The error for a missing label lists the available labels with their volumes.
TEST(LabeledComponent, MissingLabel_ListsAvailableOnes) {
  const int wanted[] = {7};
  const auto component = largest_labeled_component(box_with_core(), wanted);
  ASSERT_FALSE(component);
  EXPECT_EQ(component.error().message, "label 7 is not in the segmentation; it has 5 (120 mL), 200 (1 mL)");
}

// The error for an empty segmentation states that it has no labels.
TEST(LabeledComponent, EmptySegmentationIsReported) {
  LabelVolume empty = box_with_core();
  std::fill(empty.samples.begin(), empty.samples.end(), std::uint16_t(0));
  const int wanted[] = {5};
  EXPECT_EQ(largest_labeled_component(empty, wanted).error().message,
            "label 5 is not in the segmentation; it has no labels");
}

// A component that touches the border of the volume is noted with its count of voxels.
TEST(LabeledComponent, NotesVoxelsAtBorder) {
  LabelVolume labels = box_with_core();
  labels.at(10, 8, 6) = 0;
  for (int k = 6; k < 8; k++) labels.at(3, 3, k) = 5;
  const int wanted[] = {5};
  const auto component = largest_labeled_component(labels, wanted);
  ASSERT_TRUE(component);
  ASSERT_EQ(component->notes.size(), 1u);
  EXPECT_NE(component->notes[0].find("(1 voxel at the ends of k)"), std::string::npos) << component->notes[0];
}

// Voxels of other labels inside of a component are enclosed; a notch that reaches the outside is not.
TEST(LabeledComponent, EnclosedLabelsHaveNoWayOut) {
  LabelVolume labels = box_with_core();
  labels.at(6, 5, 4) = 0;                          // a bubble
  labels.at(4, 2, 4) = 7, labels.at(4, 3, 4) = 7;  // a notch in a side
  const int wanted[] = {5};
  const auto component = largest_labeled_component(labels, wanted);
  ASSERT_TRUE(component);
  const auto enclosed = enclosed_labels(labels, component->inside);
  ASSERT_EQ(enclosed.size(), 2u);
  EXPECT_EQ(enclosed[0].label, 0);
  EXPECT_EQ(enclosed[1].label, 200);
  for (const EnclosedLabel& e : enclosed) EXPECT_NEAR(e.volume, 1e-6, 1e-12);
  const int both[] = {5, 200};
  EXPECT_EQ(enclosed_labels(labels, largest_labeled_component(labels, both)->inside).size(), 1u);
}

// Filling adds the enclosed voxels, with their volume, and leaves labels of other bodies out.
TEST(LabeledComponent, FilledCavitiesKeepOtherBodiesOut) {
  LabelVolume labels = box_with_core();
  labels.at(6, 5, 4) = 0;  // a bubble
  const int wanted[] = {5}, other[] = {200};
  const auto hollow = largest_labeled_component(labels, wanted);
  ASSERT_TRUE(hollow);
  LabeledComponent solid = *hollow, around = *hollow;
  EXPECT_EQ(fill_cavities(labels, {}, solid).size(), 2u);
  EXPECT_NEAR(solid.volume, 4 * 5 * 6 * 1e-6, 1e-12);
  EXPECT_TRUE(enclosed_labels(labels, solid.inside).empty());
  EXPECT_EQ(fill_cavities(labels, other, around).size(), 1u);
  EXPECT_EQ(around.inside[sample_index(labels.grid, 4, 4, 3)], 0);
  EXPECT_EQ(around.inside[sample_index(labels.grid, 6, 5, 4)], 1);
}

}  // namespace
}  // namespace turgor
