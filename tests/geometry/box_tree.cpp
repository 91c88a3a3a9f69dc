#include "turgor/geometry/box_tree.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

std::vector<Box> random_boxes(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Box> boxes;
  for (int i = 0; i < count; i++) {
    const Vec3d low{place(random), place(random), place(random)};
    boxes.push_back({low, low + Vec3d{place(random), place(random), place(random)} * 0.1});
  }
  return boxes;
}

TEST(BoxTree, it_finds_exactly_the_boxes_that_meet_a_box) {
  const std::vector<Box> boxes = random_boxes(1000);
  const BoxTree tree = build_box_tree(boxes);
  for (const Box& asked : random_boxes(50)) {
    std::vector<int> found, expected;
    visit_meeting(tree, asked, [&](int i) {
      if (meet(boxes[std::size_t(i)], asked)) found.push_back(i);
      return false;
    });
    for (int i = 0; i < 1000; i++)
      if (meet(boxes[std::size_t(i)], asked)) expected.push_back(i);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(BoxTree, a_visit_that_is_content_ends_the_search) {
  const std::vector<Box> boxes(100, Box{{0, 0, 0}, {1, 1, 1}});
  int visits = 0;
  visit_meeting(build_box_tree(boxes), {{0, 0, 0}, {1, 1, 1}}, [&](int) { return ++visits == 3; });
  EXPECT_EQ(visits, 3);
}

TEST(BoxTree, equal_boxes_and_no_boxes_make_trees_too) {
  EXPECT_EQ(build_box_tree(std::vector<Box>(500, Box{})).items.size(), 500u);
  EXPECT_EQ(nearest_item(build_box_tree({}), {}, 1, [](int, double) { return 0.0; }), -1);
}

}  // namespace
}  // namespace turgor
