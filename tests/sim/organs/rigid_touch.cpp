// Tools and cloth on rigid bodies, against closed forms: forces of both sides, momentum, friction, weights.
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;
using test::organs_world;

constexpr double kWeighty = 9.81;  // [m/s²]

std::string touched_world(const std::string& bodies, const std::string& gravity = "[0, 0, -9.81]") {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n" + bodies;
}
std::string stiff_text(const std::string& name, const std::string& shape, const std::string& at,
                       const std::string& keys) {
  return "[body." + name + "]\nmodel = \"rigid\"\nshape = " + shape + "\nat = " + at + "\n" + keys +
         "touch_stiffness = 1500\n";
}
std::string floor_text(const std::string& name, const std::string& keys = "friction = 0\n") {
  return "[contact." + name + "-floor]\nbetween = [\"" + name + "\", \"ground\"]\n" + keys;
}
/// A ball of 5 mm as a tool along a path.
std::string probe_text(const std::string& body, const std::string& rows, double friction) {
  return fmt::format(
      "[tool.probe]\nbody = \"{}\"\nshape = {{ sphere = 0.005 }}\nfriction = {}\ninterpolation = "
      "\"linear\"\npath = [{}]\n",
      body, friction, rows);
}
Vec3d tool_force(const World& world) { return world.tools[0].samples.back().force; }

// A tool presses a ball on the ground: the force is the stiffness of the touched point times the depth, and
// the ground bears it with the ball's weight.
TEST(RigidTouch, BallOnGround_BearsTool) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      touched_world(
          stiff_text("ball", "{ sphere = 0.02 }", "[0.1, 0.2, 0.02]", "mass = 0.1\n") + floor_text("ball") +
          probe_text("ball", "[0, 0.1, 0.2, 0.047], [0.2, 0.1, 0.2, 0.0438], [9, 0.1, 0.2, 0.0438]", 0.3)));
  advance(exec, world, 60);
  const RigidBody& ball = world.rigid_bodies[0];
  const double depth = ball.state.center.z + 0.025 - 0.0438, expected = 1500 * depth;
  const Vec3d force = tool_force(world), ground = world.coupling.contacts[0].samples.back().force;
  std::printf("force %.6f N, expected %.6f; ground %.6f N\n", force.z, expected, ground.z);
  EXPECT_GT(expected, 1.5);
  EXPECT_NEAR(force.z, expected, 1e-6 * expected);
  EXPECT_LT(std::hypot(force.x, force.y), 1e-6);
  EXPECT_NEAR(ground.z, force.z + 0.1 * kWeighty, 1e-6 * ground.z);
  EXPECT_EQ(world.coupling.unsolved, 0);
}

// A tool strikes a free box off its center: in every frame, the impulses of its force and torque are those
// that the box receives.
TEST(RigidTouch, StruckBox_KeepsMomentum) {
  const Exec exec(2);
  World world = organs_world(
      exec, touched_world(stiff_text("box", "{ box = [0.04, 0.06, 0.03] }", "[0, 0, 0]",
                                     "density = 900\nturn = [10, 20, 30]\nspin = [0, 1, 2]\n") +
                              probe_text("box", "[0, -0.05, 0.012, 0.006], [2, 0.15, 0.02, 0.0]", 0),
                          "[0, 0, 0]"));
  const RigidBody& box = world.rigid_bodies[0];
  const auto linear = [&] { return box.model.mass.mass * box.state.velocity; };
  const auto angular = [&] { return cross(box.state.center, linear()) + box.state.momentum; };
  int touched = 0;
  double worst = 0, most = 0;
  for (int n = 0; n < 60; n++) {
    const Vec3d p = linear(), l = angular(), at = box.touches[0].pose.position;
    advance(exec, world, 1);
    const ForceSample& tool = world.tools[0].samples.back();
    const Vec3d impulse = -world.dt * tool.force;
    const Vec3d twist = -world.dt * (tool.torque + cross(at, tool.force));
    touched += tool.contacts > 0;
    most = std::max(most, norm(impulse));
    worst = std::max({worst, norm(linear() - p - impulse), norm(angular() - l - twist) / 0.05});
  }
  std::printf("%d frames in contact, largest impulse %.4g N s, error %.2g N s\n", touched, most, worst);
  EXPECT_GT(touched, 2);
  EXPECT_GT(norm(linear()), 1e-3);
  EXPECT_LT(worst, 1e-6 * most);
}

// A tool pushes a box over the ground: at constant speed it feels the friction of the ground, μ m g.
TEST(RigidTouch, PushedBox_FeelsFrictionOfGround) {
  const Exec exec(2);
  World world = organs_world(
      exec, touched_world(stiff_text("box", "{ box = [0.06, 0.06, 0.03] }", "[0, 0, 0.015]", "mass = 0.2\n") +
                          floor_text("box", "friction = 0.35\n") +
                          probe_text("box", "[0, -0.037, 0, 0.012], [5, 0.113, 0, 0.012]", 0)));
  advance(exec, world, 120);
  const Vec3d force = tool_force(world);
  const double expected = 0.35 * 0.2 * kWeighty;
  std::printf("force %.5f N, friction %.5f N, speed %.4f m/s\n", -force.x, expected,
              world.rigid_bodies[0].state.velocity.x);
  EXPECT_NEAR(world.rigid_bodies[0].state.velocity.x, 0.03, 1e-3 * 0.03);
  EXPECT_NEAR(-force.x, expected, 1e-3 * expected);
}

// A tool that slides over a fixed block feels Coulomb's friction; one that rests sticks.
TEST(RigidTouch, SlidingTool_FeelsCoulombFriction) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      touched_world(stiff_text("block", "{ box = [0.2, 0.06, 0.02] }", "[0, 0, -0.01]",
                               "density = 900\nfixed = true\n") +
                    probe_text("block",
                               "[0, -0.05, 0.01, 0.006], [0.2, -0.05, 0.01, 0.0046], [0.4, -0.05, 0.01, "
                               "0.0046], [2.4, 0.05, 0.01, 0.0046], [9, 0.05, 0.01, 0.0046]",
                               0.25)));
  advance(exec, world, 22);
  EXPECT_NEAR(tool_force(world).z, 1500 * 0.0004, 1e-6) << "the depth is 0.4 mm";
  EXPECT_LT(std::abs(tool_force(world).x), 1e-6);
  advance(exec, world, 60);
  EXPECT_NEAR(tool_force(world).z, 0.6, 1e-6);
  EXPECT_NEAR(tool_force(world).x, -0.25 * 0.6, 1e-6);
}

// Forceps take a ball from the ground, carry its weight, and drop it.
TEST(RigidTouch, Grasp_CarriesWeightAndDrops) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      touched_world(
          stiff_text("ball", "{ sphere = 0.01 }", "[0, 0, 0.01]", "mass = 0.05\n") + floor_text("ball") +
          "[tool.forceps]\nbody = \"ball\"\nshape = { forceps = \"phantom\", opening = 0.012, "
          "closing = 0.1 }\ngrasp = { at_fraction = [0.5, 0.5, 1], depth = 0.001, pull = 0.03, start "
          "= 0, duration = 0.3, hold = 0.3 }\n"));
  const RigidBody& ball = world.rigid_bodies[0];
  double highest = 0, weight = 0;
  for (int n = 0; n < 240; n++) {
    advance(exec, world, 1);
    highest = std::max(highest, ball.state.center.z);
    if (ball.state.center.z > 0.035 && norm(ball.state.velocity) < 1e-5) weight = -tool_force(world).z;
  }
  std::printf("lifted to %.4f m, weight in the hand %.5f N of %.5f\n", highest, weight, 0.05 * kWeighty);
  EXPECT_NEAR(highest, 0.01 + 0.03, 0.002);
  EXPECT_NEAR(weight, 0.05 * kWeighty, 1e-3);
  EXPECT_NEAR(ball.state.center.z, 0.01, 1e-4) << "it lies on the ground again";
}

// A sheet falls on a box: the ground below it bears the weights of both.
TEST(RigidTouch, SheetOnBox_GroundBearsBoth) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      touched_world(
          stiff_text("box", "{ box = [0.1, 0.1, 0.02] }", "[0, 0, 0.01]", "mass = 0.3\n") +
          floor_text("box", "friction = 0.3\n") +
          "[body.sheet]\nmodel = \"cloth\"\nsheet = { corner = [-0.04, -0.04, 0.024], side = [0.08, 0, "
          "0], up = [0, 0.08, 0], columns = 8, rows = 8 }\nfabric = { density = 2 }\ncollision = { thickness "
          "= 0.001 }\n[body.sheet.obstacle.box]\nbody = \"box\"\nfriction = 0.3\n"));
  advance(exec, world, 180);
  const double box = 0.3 * kWeighty, sheet = world.cloth_bodies[0].model.total_mass * kWeighty;
  const Vec3d ground = world.coupling.contacts[0].samples.back().force;
  const Vec3d on_box = world.cloth_bodies[0].obstacles[0].force.back();
  std::printf("sheet %.6f N of %.6f; ground %.6f N of %.6f\n", -on_box.z, sheet, ground.z, box + sheet);
  EXPECT_NEAR(-on_box.z, sheet, 1e-3 * sheet);
  EXPECT_NEAR(ground.z - box, sheet, 1e-3 * sheet);
}

std::string struck_stone() {
  return touched_world(
      stiff_text("stone", "{ box = [0.02, 0.03, 0.02] }", "[0, 0, 0.0101]", "density = 2000\n") +
      floor_text("stone", "friction = 0.2\n") +
      probe_text("stone", "[0, -0.03, 0.004, 0.012], [1, 0.02, 0, 0.01]", 0.4));
}

// A pushed stone has the same bits on any number of threads, and after a copy.
TEST(RigidTouch, Stone_SameBits) {
  World world = organs_world(Exec(1), struck_stone());
  advance(Exec(1), world, 20);
  World copy = copy_of(world);
  advance(Exec(1), world, 20);
  advance(Exec(8), copy, 20);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_GT(norm(world.rigid_bodies[0].state.velocity), 1e-3);
}

// The virtual device of a haptic session presses a fixed block: it feels the stiffness of the touched point
// times the depth.
TEST(RigidTouch, VirtualDevice_FeelsStiffness) {
  const std::filesystem::path folder = test::fresh_folder();
  std::ofstream(folder / "block.toml") << touched_world(
      "[body.block]\nmodel = \"rigid\"\nshape = { box = [0.1, 0.1, 0.02] }\nat = [0, 0, -0.01]\ndensity = "
      "900\nfixed = true\ntouch_stiffness = 300\n");
  Session session(folder / "block.toml", {}, test::kOneThread);
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  const Vec3d at{0.01, 0.01, 0.008 - 0.002};  // the fingertip has a radius of 8 mm
  for (const MouseTool& mouse : session.now().mouse)
    mouse.device->set_target({.pose = {at, {}}, .teleports = 1, .teleport_to = at + Vec3d{0, 0, 0.006}});
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) {
    if (now.snapshot.tools.empty()) return false;
    const double depth = 0.008 - now.snapshot.tools[0].pose.position.z;
    return depth > 0.001 && std::abs(now.snapshot.tools[0].force.z - 300 * depth) < 0.01 * 300 * depth;
  }));
}

TEST(RigidTouch, Needle_IsRefused) {
  const Result<Scene> scene = parse_scene(
      touched_world(stiff_text("box", "{ box = [0.04, 0.04, 0.02] }", "[0, 0, 0]", "density = 900\n") +
                    "[tool.needle]\nbody = \"box\"\nshape = { needle = 0.05 }\npath = [[0, 0, 0, 0.1], [1, "
                    "0, 0, 0]]\n"),
      "needle.toml");
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("found model = \"rigid\", which has no needles"), std::string::npos)
      << scene.error().message;
}

}  // namespace
}  // namespace turgor
