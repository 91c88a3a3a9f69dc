#include "turgor/geometry/box_tree.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

std::vector<Box> random_boxes(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<Box> boxes;
  for (int i = 0; i < count; i++) {
    const Vec3d low{coordinate(random), coordinate(random), coordinate(random)};
    boxes.push_back({low, low + Vec3d{coordinate(random), coordinate(random), coordinate(random)} * 0.1});
  }
  return boxes;
}

// A query finds exactly the boxes that overlap the query box.
TEST(BoxTree, Query_MatchesBruteForce) {
  const std::vector<Box> boxes = random_boxes(1000);
  const BoxTree tree = build_box_tree(boxes);
  for (const Box& query : random_boxes(50)) {
    std::vector<int> found, expected;
    visit_meeting(tree, query, [&](int i) {
      if (meet(boxes[std::size_t(i)], query)) found.push_back(i);
      return false;
    });
    for (int i = 0; i < 1000; i++)
      if (meet(boxes[std::size_t(i)], query)) expected.push_back(i);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

// The search ends when the visitor returns true.
TEST(BoxTree, VisitorEndsSearch) {
  const std::vector<Box> boxes(100, Box{{0, 0, 0}, {1, 1, 1}});
  int visits = 0;
  visit_meeting(build_box_tree(boxes), {{0, 0, 0}, {1, 1, 1}}, [&](int) { return ++visits == 3; });
  EXPECT_EQ(visits, 3);
}

// A tree is built of equal boxes and of no boxes.
TEST(BoxTree, EqualAndMissingBoxes) {
  EXPECT_EQ(build_box_tree(std::vector<Box>(500, Box{})).items.size(), 500u);
  EXPECT_EQ(nearest_item(build_box_tree({}), {}, 1, [](int, double) { return 0.0; }), -1);
}

}  // namespace
}  // namespace turgor
