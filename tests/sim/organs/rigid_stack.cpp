// Rigid boxes and cylinders that stand on others: boxes of any proportions, flush stacks, overhangs and
// rocking.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "turgor/geometry/quaternion.hpp"

namespace turgor {
namespace {

using test::advance;
using test::organs_world;

constexpr double kMass = 0.1, kWeight = kMass * 9.81;
constexpr double kDegree = std::numbers::pi / 180;
const std::string kStackWorld = "[world]\nduration = 20\ngravity = [0, 0, -9.81]\n";
const std::string kStackPlate =
    "[body.plate]\nmodel = \"rigid\"\nshape = { box = [0.2, 0.2, 0.02] }\nat = [0, 0, -0.01]\nmass = 1\n"
    "fixed = true\n";

std::string standing_text(const std::string& name, const std::string& shape, Vec3d at, double yaw = 0) {
  return fmt::format(
      "[body.{}]\nmodel = \"rigid\"\nshape = {}\nat = [{}, {}, {}]\nmass = {}\nturn = [0, 0, {}]\n", name,
      shape, at.x, at.y, at.z, kMass, yaw);
}
std::string contact_text(const std::string& a, const std::string& b) {
  return fmt::format("[contact.{}-{}]\nbetween = [\"{}\", \"{}\"]\nfriction = 0.5\n", a, b, a, b);
}

/// Angle between the vertical and an axis of a body that had the given direction at the beginning [°].
double tilt_of_axis(const RigidBody& body, Vec3d axis = {0, 0, 1}) {
  const Vec3d now = axes_of(body.state.rotation) * axis;
  return std::atan2(norm(cross(now, {0, 0, 1})), now.z) / kDegree;
}
const RigidBody& body_named(const World& world, const std::string& name) {
  for (const RigidBody& body : world.rigid_bodies)
    if (body.name == name) return body;
  ADD_FAILURE() << name;
  return world.rigid_bodies[0];
}

// Boxes of several proportions stand on a plate, which bears their weight.
TEST(RigidStack, Box_StandsOnPlate) {
  const Exec exec(2);
  for (const Vec3d size : {Vec3d{0.02, 0.02, 0.06}, Vec3d{0.04, 0.04, 0.04}, Vec3d{0.03, 0.03, 0.04},
                           Vec3d{0.01, 0.02, 0.08}, Vec3d{0.05, 0.01, 0.03}, Vec3d{0.03, 0.05, 0.002}}) {
    const std::string shape = fmt::format("{{ box = [{}, {}, {}] }}", size.x, size.y, size.z);
    World world = organs_world(exec, kStackWorld + kStackPlate +
                                         standing_text("b", shape, {0.01, 0.02, size.z / 2}, 17 * size.z) +
                                         contact_text("b", "plate"));
    advance(exec, world, 60);
    EXPECT_LT(norm(world.coupling.contacts[0].samples.back().force - Vec3d{0, 0, kWeight}), 1e-3 * kWeight)
        << shape;
    EXPECT_LT(tilt_of_axis(body_named(world, "b")), 0.1) << shape;
    EXPECT_EQ(world.coupling.unsolved, 0) << shape;
  }
}

/// Stack of equal cubes on the ground. Every second one is moved aside and turned.
struct Stack {
  int count = 2;
  Vec3d aside;                                  // [m]
  double yaw = 0;                               // [°]
  bool is_turned = false, is_reversed = false;  // all cubes are turned; the lower cube is named first
};
std::string stack_text(const Stack& stack) {
  std::string text = kStackWorld;
  for (int n = 0; n < stack.count; n++) {
    const Vec3d at = stack.aside * (n % 2) + Vec3d{0, 0, 0.02 + 0.04 * n};
    text += standing_text(fmt::format("c{}", n), "{ box = [0.04, 0.04, 0.04] }", at,
                          n % 2 == 1 || stack.is_turned ? stack.yaw : 0);
    const std::string name = fmt::format("c{}", n), below = fmt::format("c{}", n - 1);
    text += n == 0 ? contact_text(name, "ground")
                   : contact_text(stack.is_reversed ? below : name, stack.is_reversed ? name : below);
  }
  return text;
}

// Cubes rest on each other flush, aside and turned, in either order of `between`. Every contact bears the
// weight above it.
TEST(RigidStack, Cubes_RestOnEachOther) {
  const Exec exec(2);
  const Stack kinds[] = {{},
                         {.aside = {0.01, 0, 0}},
                         {.aside = {0, 1e-4, 0}},
                         {.aside = {3e-6, -2e-6, 0}},
                         {.aside = {0.012, 0.007, 0}},
                         {.aside = {}, .yaw = 30},
                         {.aside = {}, .yaw = 30, .is_turned = true},
                         {.aside = {}, .yaw = 0.02},
                         {.aside = {}, .yaw = 1},
                         {.aside = {0.005, 0, 0}, .yaw = 75}};
  for (Stack stack : kinds)
    for (const int count : {2, 3})
      for (const bool is_reversed : {false, true}) {
        stack.count = count, stack.is_reversed = is_reversed;
        const std::string text = stack_text(stack);
        World world = organs_world(exec, text);
        advance(exec, world, 60);
        for (const BodyContact& contact : world.coupling.contacts) {
          // the lower of the two carries the others
          const bool on_ground = contact.name.ends_with("ground");
          const int lower = on_ground ? -1 : std::min(contact.name[1], contact.name[4]) - '0';
          const double weight = kWeight * (count - 1 - lower);
          const double sign = is_reversed && !on_ground ? -1 : 1;
          EXPECT_LT(norm(contact.samples.back().force - Vec3d{0, 0, sign * weight}), 1e-3 * weight)
              << contact.name << "\n"
              << text;
        }
        for (const RigidBody& body : world.rigid_bodies)
          EXPECT_LT(tilt_of_axis(body), 0.1) << body.name << "\n" << text;
        EXPECT_EQ(world.coupling.unsolved, 0) << text;
      }
}

// A box on an equal one stays while its center of mass is above the lower one, and else falls.
TEST(RigidStack, Overhang_FallsBeyondHalf) {
  const Exec exec(2);
  for (const Vec3d size : {Vec3d{0.04, 0.04, 0.04}, Vec3d{0.02, 0.02, 0.06}})
    for (const double of_half : {0.95, 1.05}) {
      const std::string shape = fmt::format("{{ box = [{}, {}, {}] }}", size.x, size.y, size.z);
      World world =
          organs_world(exec, kStackWorld + kStackPlate + standing_text("low", shape, {0, 0, size.z / 2}) +
                                 standing_text("high", shape, {of_half * size.x / 2, 0, 1.5 * size.z}) +
                                 contact_text("low", "plate") + contact_text("high", "low"));
      advance(exec, world, 60);
      const RigidBody& high = body_named(world, "high");
      std::printf("%s, %.2f: %.3f°, %.4f m high\n", shape.c_str(), of_half, tilt_of_axis(high),
                  high.state.center.z);
      if (of_half < 1)
        EXPECT_LT(tilt_of_axis(high), 0.1) << shape;
      else
        EXPECT_LT(high.state.center.z, size.z) << shape;
    }
}

/// Writes a closed cylinder along z around the origin, in meters.
void write_cylinder(const std::filesystem::path& file, int sides, double radius, double height) {
  std::string text;
  for (const double z : {-height / 2, height / 2})
    for (int n = 0; n < sides; n++) {
      const double angle = 2 * std::numbers::pi * n / sides;
      text += fmt::format("v {} {} {}\n", radius * std::cos(angle), radius * std::sin(angle), z);
    }
  text += fmt::format("v 0 0 {}\nv 0 0 {}\n", -height / 2, height / 2);
  for (int n = 0; n < sides; n++) {
    const int a = n + 1, b = (n + 1) % sides + 1;
    text += fmt::format("f {0} {1} {3}\nf {0} {3} {2}\n", a, b, a + sides, b + sides);
    text += fmt::format("f {} {} {}\nf {} {} {}\n", 2 * sides + 1, b, a, 2 * sides + 2, a + sides, b + sides);
  }
  test::write(file, text);
}

// A cylinder that is released on the edge of its base returns to it below the angle atan(2 r/h), at which its
// center of mass is above the edge, and else falls.
TEST(RigidStack, TiltedCylinder_ReturnsBelowCriticalAngle) {
  const Exec exec(2);
  for (const auto& [radius, height] : {std::pair(0.01, 0.06), std::pair(0.015, 0.05)}) {
    const std::filesystem::path file = test::fresh_folder() / "cylinder.obj";
    write_cylinder(file, 24, radius, height);
    const double critical = std::atan2(2 * radius, height) / kDegree;
    for (const double tilt : {3.0, 0.93 * critical, 1.07 * critical}) {
      const double center = height / 2 * std::cos(tilt * kDegree) + radius * std::sin(tilt * kDegree) + 1e-5;
      World world = organs_world(
          exec, kStackWorld + kStackPlate +
                    fmt::format("[body.b]\nmodel = \"rigid\"\nshape = {{ mesh = \"{}\", scale = 1 }}\n"
                                "at = [0, 0, {}]\nmass = {}\nturn = [0, {}, 0]\n",
                                file.string(), center, kMass, tilt) +
                    contact_text("b", "plate"));
      advance(exec, world, 120);
      const Vec3d axis{std::sin(tilt * kDegree), 0, std::cos(tilt * kDegree)};
      const double end = tilt_of_axis(body_named(world, "b"), axis);
      std::printf("released at %.2f° of %.2f°: %.3f° at the end\n", tilt, critical, end);
      if (tilt > critical) {
        EXPECT_NEAR(end, 90, 5);
        continue;
      }
      EXPECT_LT(end, 0.1);
      EXPECT_LT(norm(world.coupling.contacts[0].samples.back().force - Vec3d{0, 0, kWeight}), 1e-3 * kWeight);
    }
  }
}

}  // namespace
}  // namespace turgor
