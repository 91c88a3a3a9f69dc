// Bounding volume hierarchy of axis-aligned boxes, split at the median. It finds the nearest item and all
// items that overlap a box.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/geometry/box.hpp"

namespace turgor {

struct BoxTree {
  struct Node {
    Box box;
    int first = 0;  // leaf: first index in `items`; inner node: second child (the first one follows it)
    int count = 0;  // items of a leaf; 0 = inner
  };
  std::vector<Node> nodes;  // root first; empty without boxes
  std::vector<int> items;   // box indices, leaf by leaf
};

BoxTree build_box_tree(std::span<const Box> boxes);

/// Calls visit(item) for every item of every leaf whose box meets `box`; visit returns true to stop.
template <class Visit>
void visit_meeting(const BoxTree& tree, const Box& box, const Visit& visit) {
  std::array<int, 64> stack;  // deeper than any median-split tree
  int depth = 0;
  if (!tree.nodes.empty()) stack[std::size_t(depth++)] = 0;
  while (depth > 0) {
    const int n = stack[std::size_t(--depth)];
    const BoxTree::Node& node = tree.nodes[std::size_t(n)];
    if (!meet(node.box, box)) continue;
    for (int i = 0; i < node.count; i++)
      if (visit(tree.items[std::size_t(node.first + i)])) return;
    if (node.count > 0) continue;
    stack[std::size_t(depth++)] = node.first;
    stack[std::size_t(depth++)] = n + 1;
  }
}

/// The tree as plain pointers.
struct BoxTreeView {
  const BoxTree::Node* nodes = nullptr;
  const int* items = nullptr;
  int node_count = 0;
};
inline BoxTreeView view(const BoxTree& tree) {
  return {tree.nodes.data(), tree.items.data(), int(tree.nodes.size())};
}

/// Item nearest to a point: measure(item, best) returns the item's squared distance, or any value ≥ best.
/// Ties go to the first one found. -1 if no item is nearer than the initial `best`.
template <class Measure>
TURGOR_HD int nearest_item(const BoxTreeView& tree, Vec3d p, double best, const Measure& measure) {
  int stack[64];
  int depth = 0, nearest = -1;
  if (tree.node_count > 0) stack[depth++] = 0;
  while (depth > 0) {
    const int n = stack[--depth];
    const BoxTree::Node& node = tree.nodes[n];
    if (squared_distance(node.box, p) >= best) continue;
    for (int i = 0; i < node.count; i++) {
      const int item = tree.items[node.first + i];
      if (const double d = measure(item, best); d < best) best = d, nearest = item;
    }
    if (node.count > 0) continue;
    const bool swap =
        squared_distance(tree.nodes[n + 1].box, p) > squared_distance(tree.nodes[node.first].box, p);
    stack[depth++] = swap ? n + 1 : node.first;  // the nearer child is popped first
    stack[depth++] = swap ? node.first : n + 1;
  }
  return nearest;
}
template <class Measure>
int nearest_item(const BoxTree& tree, Vec3d p, double best, const Measure& measure) {
  return nearest_item(view(tree), p, best, measure);
}

}  // namespace turgor
