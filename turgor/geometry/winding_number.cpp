#include "turgor/geometry/winding_number.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace turgor {

namespace {

// Distance in node radii from which a node is approximated by its dipole; the error is then some thousandths.
constexpr double kFar = 3;

std::array<Vec3d, 3> corners(const TriangleTree& tree, int triangle) {
  const Int3 t = tree.triangles[std::size_t(triangle)];
  return {tree.vertices[std::size_t(t.x)], tree.vertices[std::size_t(t.y)], tree.vertices[std::size_t(t.z)]};
}

/// Solid angle of a triangle seen from p, positive from inside. [van Oosterom, Strackee 1983]
double solid_angle(const std::array<Vec3d, 3>& x, Vec3d p) {
  const Vec3d a = x[0] - p, b = x[1] - p, c = x[2] - p;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// Sums over the triangles below a node, and the node after them.
struct Sums {
  Vec3d area, moment;  // moment: centroid times area
  double size = 0;     // unsigned area [m²]
};

Sums fill_node(const TriangleTree& tree, std::size_t n, WindingNodes& winding) {
  const BoxTree::Node& node = tree.boxes.nodes[n];
  Sums sums;
  for (int i = 0; i < node.count; i++) {
    const auto [a, b, c] = corners(tree, tree.boxes.items[std::size_t(node.first + i)]);
    const Vec3d area = cross(b - a, c - a) * 0.5;
    sums.area += area;
    sums.moment += (a + b + c) * (norm(area) / 3);
    sums.size += norm(area);
  }
  if (node.count == 0)
    for (const std::size_t child : {n + 1, std::size_t(node.first)}) {
      const Sums child_sums = fill_node(tree, child, winding);
      sums.area += child_sums.area, sums.moment += child_sums.moment, sums.size += child_sums.size;
    }
  const Box box = node.box;
  const Vec3d middle = sums.size > 0 ? sums.moment / sums.size : (box.low + box.high) * 0.5;
  const Vec3d reach = max(box.high - middle, middle - box.low);
  winding.nodes[n] = {middle, sums.area, kFar * kFar * dot(reach, reach)};
  return sums;
}

}  // namespace

WindingNodes winding_nodes(const TriangleTree& tree) {
  WindingNodes winding;
  winding.nodes.resize(tree.boxes.nodes.size());
  if (!winding.nodes.empty()) fill_node(tree, 0, winding);
  return winding;
}

double winding_number(const TriangleTree& tree, const WindingNodes& winding, Vec3d p) {
  std::array<int, 64> stack;
  int depth = 0;
  if (!winding.nodes.empty()) stack[std::size_t(depth++)] = 0;
  double angle = 0;
  while (depth > 0) {
    const int n = stack[std::size_t(--depth)];
    const WindingNodes::Node& far = winding.nodes[std::size_t(n)];
    const Vec3d direction = far.middle - p;
    if (const double d2 = dot(direction, direction); d2 > far.far2) {
      angle += dot(far.area, direction) / (d2 * std::sqrt(d2));
      continue;
    }
    const BoxTree::Node& node = tree.boxes.nodes[std::size_t(n)];
    for (int i = 0; i < node.count; i++)
      angle += solid_angle(corners(tree, tree.boxes.items[std::size_t(node.first + i)]), p);
    if (node.count > 0) continue;
    stack[std::size_t(depth++)] = node.first;
    stack[std::size_t(depth++)] = n + 1;
  }
  return angle / (4 * std::numbers::pi);
}

}  // namespace turgor
