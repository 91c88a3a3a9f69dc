#include "turgor/contact/tool.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

namespace {

/// Of a ball around `centre`.
ShapeDistance ball_distance(Vec3d centre, double radius, Vec3d x) {
  const Vec3d d = x - centre;
  const double length = norm(d);
  return {length - radius, length > 0 ? d / length : Vec3d{0, 0, 1}};
}

ShapeDistance distance_of(const Sphere& s, Vec3d x) { return ball_distance({}, s.radius, x); }

ShapeDistance distance_of(const Capsule& c, Vec3d x) {
  return ball_distance({0, 0, std::clamp(x.z, -c.half_length, c.half_length)}, c.radius, x);
}

/// Weights of the eight nodes around a place of the grid.
ShapeDistance interpolate(const MeshShape& m, Vec3d grid_place) {
  Int3 cell;
  Vec3d t;
  for (int axis = 0; axis < 3; axis++) {
    cell[axis] = std::clamp(int(grid_place[axis]), 0, m.size[axis] - 2);
    t[axis] = grid_place[axis] - cell[axis];
  }
  double distance = 0;
  Vec3d normal;
  for (int corner = 0; corner < 8; corner++) {
    const Int3 bit{corner & 1, corner >> 1 & 1, corner >> 2};
    const double w = (bit.x ? t.x : 1 - t.x) * (bit.y ? t.y : 1 - t.y) * (bit.z ? t.z : 1 - t.z);
    const auto n = std::size_t(((cell.z + bit.z) * m.size.y + cell.y + bit.y) * m.size.x + cell.x + bit.x);
    distance += w * m.nodes[n].distance;
    normal += w * Vec3d(m.nodes[n].normal);
  }
  const double length = norm(normal);
  return {distance, length > 0 ? normal / length : Vec3d{0, 0, 1}};
}

/// Beyond the grid, the distance to the place of the surface that is nearest to the grid's border there.
ShapeDistance distance_of(const MeshShape& m, Vec3d x) {
  const Vec3d place = (x - m.corner) / m.spacing;
  const Vec3d inside = max(min(place, Vec3d(m.size) - Vec3d{1, 1, 1}), Vec3d{});
  const ShapeDistance near = interpolate(m, inside);
  if (inside == place) return near;
  const Vec3d surface = m.corner + inside * m.spacing - near.normal * near.distance;
  return ball_distance(surface, 0, x);
}

/// Balls along a capsule's axis. What lies between them is found as well: a site's distance is that from the
/// whole capsule.
int ball_count(const Capsule& c) {
  constexpr double kApart = 4;  // radii
  constexpr int kMost = 5;
  return c.half_length > 0 ? std::min(kMost, 2 + int(2 * c.half_length / (kApart * c.radius))) : 1;
}

struct BoundingRadius {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Capsule& c) const { return c.radius + c.half_length; }
  double operator()(const MeshShape& m) const { return m.bounding_radius; }
};
struct TipRadius {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Capsule& c) const { return c.radius; }
  double operator()(const MeshShape& m) const { return m.tip_radius; }
};
struct TipCount {
  int operator()(const Sphere&) const { return 1; }
  int operator()(const Capsule& c) const { return ball_count(c); }
  int operator()(const MeshShape& m) const { return int(m.tips.size()); }
};
struct Tip {
  int index;
  Vec3d operator()(const Sphere&) const { return {}; }
  Vec3d operator()(const Capsule& c) const {
    const int last = ball_count(c) - 1;
    return {0, 0, last == 0 ? 0 : c.half_length * (2.0 * index / last - 1)};
  }
  Vec3d operator()(const MeshShape& m) const { return m.tips[std::size_t(index)]; }
};

}  // namespace

bool is_valid(const Pose& pose) {
  const auto& [a, b, c] = pose.axes.column;
  constexpr double kSlack = 1e-3;
  for (const double error : {dot(a, a) - 1, dot(b, b) - 1, dot(c, c) - 1, dot(a, b), dot(b, c), dot(c, a),
                             determinant(pose.axes) - 1})
    if (!(std::abs(error) < kSlack)) return false;
  const Vec3d& x = pose.position;
  return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z);
}

ShapeDistance distance(const Shape& shape, Vec3d x) {
  return std::visit([x](const auto& s) { return distance_of(s, x); }, shape);
}

ShapeDistance distance(const Shape& shape, const Pose& pose, Vec3d x) {
  ShapeDistance d = distance(shape, to_tool(pose, x));
  d.normal = pose.axes * d.normal;
  return d;
}

double bounding_radius(const Shape& shape) { return std::visit(BoundingRadius{}, shape); }
double tip_radius(const Shape& shape) { return std::visit(TipRadius{}, shape); }
int tip_count(const Shape& shape) { return std::visit(TipCount{}, shape); }
Vec3d tip(const Shape& shape, int index) { return std::visit(Tip{index}, shape); }

// The regions around a triangle, each told by signs of dot products. [Ericson, Real-Time Collision Detection
// 5.1.5]
Vec3d closest_weights(Vec3d x, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, ac = c - a;
  const double d1 = dot(ab, x - a), d2 = dot(ac, x - a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = dot(ab, x - b), d4 = dot(ac, x - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = dot(ab, x - c), d6 = dot(ac, x - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double on_c = d1 * d4 - d3 * d2;
  if (on_c <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double on_b = d5 * d2 - d1 * d6;
  if (on_b <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double on_a = d3 * d6 - d5 * d4;
  if (on_a <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double sum = on_a + on_b + on_c;
  return {1 - on_b / sum - on_c / sum, on_b / sum, on_c / sum};
}

}  // namespace turgor::contact
