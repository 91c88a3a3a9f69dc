#include "turgor/contact/tool.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

namespace {

ShapeDistance distance_of(const Sphere& s, Vec3d x) { return ball_distance({}, s.radius, x); }
ShapeDistance distance_of(const Capsule& c, Vec3d x) { return rod_distance(c.radius, c.half_length, x); }
ShapeDistance distance_of(const MeshShape& m, Vec3d x) { return grid_distance(view(m), x); }

struct BoundingRadius {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Capsule& c) const { return c.radius + c.half_length; }
  double operator()(const MeshShape& m) const { return m.bounding_radius; }
};
struct NearestToOrigin {
  Vec3d operator()(const Sphere&) const { return {}; }
  Vec3d operator()(const Capsule&) const { return {}; }
  Vec3d operator()(const MeshShape& m) const {
    Vec3d nearest;
    const int nodes[3] = {m.size.x, m.size.y, m.size.z};
    for (int axis = 0; axis < 3; axis++)
      nearest[axis] = std::clamp(0.0, m.corner[axis], m.corner[axis] + m.spacing * (nodes[axis] - 1));
    return nearest;
  }
};
struct TipRadius {
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Capsule& c) const { return c.radius; }
  double operator()(const MeshShape& m) const { return m.tip_radius; }
};
struct TipCount {
  int operator()(const Sphere&) const { return 1; }
  int operator()(const Capsule& c) const { return rod_ball_count(c.radius, c.half_length); }
  int operator()(const MeshShape& m) const { return int(m.tips.size()); }
};
struct Tip {
  int index;
  Vec3d operator()(const Sphere&) const { return {}; }
  Vec3d operator()(const Capsule& c) const {
    return rod_ball(c.half_length, rod_ball_count(c.radius, c.half_length), index);
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
  return is_finite(pose.position);
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
Vec3d tool_position(const Shape& shape, const Pose& pose) {
  return to_world(pose, std::visit(NearestToOrigin{}, shape));
}
double tip_radius(const Shape& shape) { return std::visit(TipRadius{}, shape); }
int tip_count(const Shape& shape) { return std::visit(TipCount{}, shape); }
Vec3d tip(const Shape& shape, int index) { return std::visit(Tip{index}, shape); }

}  // namespace turgor::contact
