#include "turgor/contact/cloth_obstacle.hpp"

#include "turgor/contact/tick.hpp"

namespace turgor::contact {

namespace {

/// What is its own of each kind.
struct Describe {
  cloth::RigidShape& rigid;

  void operator()(const Sphere& s) const { rigid.radius = s.radius; }
  void operator()(const Capsule& c) const { rigid.radius = c.radius, rigid.half_length = c.half_length; }
  void operator()(const MeshShape& m) const { rigid.grid = view(m), rigid.tips = m.tips.data(); }
};

}  // namespace

cloth::Obstacle cloth_tool(const Shape& shape, const Pose& from, const Pose& to, double dt) {
  constexpr double kSmall = 0.25;  // of the tip's radius: it sinks in between vertices by less than 1 %
  cloth::Obstacle obstacle = cloth_obstacle(shape, from, to, dt);
  obstacle.shape.rigid.tip_count = tip_count(shape);
  obstacle.shape.rigid.too_small = kSmall * tip_radius(shape);
  obstacle.speed = motion(shape, from, to) / dt;
  return obstacle;
}

cloth::Obstacle cloth_obstacle(const Shape& shape, const Pose& from, const Pose& to, double dt) {
  cloth::Obstacle obstacle;
  obstacle.shape.kind = cloth::ObstacleShape::Kind::kRigid;
  cloth::RigidShape& rigid = obstacle.shape.rigid;
  rigid.from = from, rigid.to = to, rigid.dt = dt, rigid.bound = bounding_radius(shape);
  std::visit(Describe{rigid}, shape);
  return obstacle;
}

}  // namespace turgor::contact
