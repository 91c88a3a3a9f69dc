#include "turgor/geometry/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace turgor {

namespace {

constexpr int kLeafItems = 4;

Vec3d middle(const Box& box) { return (box.low + box.high) * 0.5; }

Box box_of(std::span<const Box> boxes, std::span<const int> items) {
  Box all = boxes[std::size_t(items[0])];
  for (const int i : items) all = joined(all, boxes[std::size_t(i)]);
  return all;
}

/// Axis along which the centers of the boxes spread most.
int widest_axis(std::span<const Box> boxes, std::span<const int> items) {
  Vec3d low = middle(boxes[std::size_t(items[0])]), high = low;
  for (const int i : items)
    low = min(low, middle(boxes[std::size_t(i)])), high = max(high, middle(boxes[std::size_t(i)]));
  const Vec3d spread = high - low;
  return spread.x >= spread.y && spread.x >= spread.z ? 0 : spread.y >= spread.z ? 1 : 2;
}

/// Appends the node over items [first, first + count), split at the median until leaves are small.
void append_node(BoxTree& tree, std::span<const Box> boxes, int first, int count) {
  const std::span<int> items = std::span(tree.items).subspan(std::size_t(first), std::size_t(count));
  const std::size_t n = tree.nodes.size();
  tree.nodes.push_back({box_of(boxes, items), first, count});
  if (count <= kLeafItems) return;
  const int axis = widest_axis(boxes, items), half = count / 2;
  const auto before = [&](int a, int b) {
    const double x = middle(boxes[std::size_t(a)])[axis], y = middle(boxes[std::size_t(b)])[axis];
    return x != y ? x < y : a < b;
  };
  std::nth_element(items.begin(), items.begin() + half, items.end(), before);
  append_node(tree, boxes, first, half);
  tree.nodes[n].first = int(tree.nodes.size());
  tree.nodes[n].count = 0;
  append_node(tree, boxes, first + half, count - half);
}

}  // namespace

BoxTree build_box_tree(std::span<const Box> boxes) {
  BoxTree tree;
  if (boxes.empty()) return tree;
  tree.items.resize(boxes.size());
  std::iota(tree.items.begin(), tree.items.end(), 0);
  append_node(tree, boxes, 0, int(boxes.size()));
  return tree;
}

}  // namespace turgor
