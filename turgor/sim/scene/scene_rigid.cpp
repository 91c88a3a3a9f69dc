#include "turgor/sim/scene/scene_rigid.hpp"

#include <numbers>

#include "turgor/sim/scene/scene_texture.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kRigidLength = inside(0, 10, "m");
const Allowed kRigidPosition = within(-100, 100, "m");
const std::vector<std::string> kRigidShapes = {"box", "sphere", "capsule", "mesh"};

/// Refuses a second shape, which would be ignored without a message.
void check_one_rigid_shape(SceneTable& shape) {
  std::string given;
  for (const std::string& kind : kRigidShapes) {
    if (!shape.has(kind)) continue;
    if (!given.empty())
      shape.fail(kind, fmt::format("a rigid body has one shape: either {} or {}, not both", given, kind));
    given = given.empty() ? kind : given;
    shape.find(kind);
  }
}

RodTool read_capsule(SceneTable& shape) {
  const toml::node* node = shape.find("capsule");
  const std::vector<double> lengths = shape.numbers("capsule", *node, kRigidLength);
  if (lengths.size() == 2) return {lengths[0], lengths[1]};
  shape.fail_value("capsule", *node, "[radius, half length] [m]");
  return {};
}

RigidShape read_rigid_shape(SceneTable& body) {
  body.require({"shape"}, "as in { sphere = 0.01 } [m]");
  SceneTable shape = body.table("shape");
  shape.describe("capsule", "m", "none",
                 "`[radius, half length]`, along the z axis: all points within the radius of a segment",
                 kRigidLength);
  check_one_rigid_shape(shape);
  if (body.has("shape")) shape.require(kRigidShapes, "a shape for the rigid body");
  RigidShape made = BoxSize{};
  if (shape.has("capsule")) {
    made = read_capsule(shape);
  } else if (shape.has("sphere")) {
    BallTool ball{.radius = 0.01};
    shape.read("sphere", ball.radius, kRigidLength, "a ball of this radius");
    made = ball;
  } else if (shape.has("mesh")) {
    SurfaceFile surface;
    shape.read_path("mesh", surface.file, {"a closed surface (OBJ, STL, PLY, VTP, VTK)", "none"});
    shape.read("scale", surface.scale, inside(0, 1e6, "m"), "meters per unit of the file of `mesh`");
    surface.is_scale_given = shape.has("scale");
    read_up(shape, "up", surface.up);
    made = surface;
  } else {
    BoxSize box;
    shape.read("box", box.size, kRigidLength, {"edges of a box around the origin", "one of the shapes"});
    made = box;
  }
  shape.finish();
  return made;
}

}  // namespace

RigidScene read_rigid_scene(SceneTable body, const std::string& name) {
  RigidScene scene{.name = name,
                   .source_location = body.location(),
                   .shape = {},
                   .at = {},
                   .turn = {},
                   .velocity = {},
                   .spin = {}};
  // shape and pose
  body.begin_group("rigid");
  scene.shape = read_rigid_shape(body);
  body.read("at", scene.at, kRigidPosition, "position of the shape's origin");
  Vec3d degrees;
  body.read("turn", degrees, within(-360, 360, "degrees"),
            "rotation about the shape's origin by the length of this vector, about its direction");
  scene.turn = degrees * (std::numbers::pi / 180);
  // mass
  body.require({"density", "mass"}, "the density or the mass of the rigid body");
  if (body.has("density") && body.has("mass"))
    body.fail("mass", "a rigid body has a density or a mass, not both");
  body.read("density", scene.density, positive("kg/m³"), {"of the whole volume", "one of the two"});
  body.read("mass", scene.mass, positive("kg"), {"instead of the density", "one of the two"});
  // motion
  body.read("velocity", scene.velocity, within(-100, 100, "m/s"), "of the center of mass, at the beginning");
  body.read("spin", scene.spin, within(-1000, 1000, "rad/s"), "angular velocity at the beginning");
  body.read("fixed", scene.is_fixed, "the body stays where it is, as a table does");
  body.read("touch_stiffness", scene.touch_stiffness, positive("N/m"),
            "of each point that a tool touches, and of a grasp; the body itself does not yield");
  read_texture(body, scene.texture);
  if (scene.is_fixed && (norm(scene.velocity) > 0 || norm(scene.spin) > 0))
    body.fail("fixed", "a fixed body has neither velocity nor spin");
  body.finish();
  return scene;
}

}  // namespace turgor
