#include "turgor/contact/cloth_obstacle.hpp"

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

/// Copies the fields of a shape.
struct FillShape {
  cloth::RigidShape& rigid;

  void operator()(const Sphere& s) const { rigid.radius = s.radius; }
  void operator()(const Capsule& c) const { rigid.radius = c.radius, rigid.half_length = c.half_length; }
  void operator()(const MeshShape& m) const { rigid.grid = view(m), rigid.tips = m.tips.data(); }
};

}  // namespace

cloth::Obstacle cloth_tool(const Shape& shape, const Pose& from, const Pose& to, double dt) {
  TURGOR_CHECK(is_step_length(dt), "a tool moves in a step of positive length");
  constexpr double kSmall =
      0.25;  // of the tip radius: smaller tools sink in between vertices by less than 1 %
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
  std::visit(FillShape{rigid}, shape);
  TURGOR_CHECK(rigid.bound > 0, "an obstacle has an extent");
  return obstacle;
}

}  // namespace turgor::contact
