// Rigid bodies in scenes: on the ground, on slopes, on each other, on tissue, and on springs.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "tests/elliptic.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;
using test::block_text;
using test::organs_scene;
using test::organs_world;

std::string rigid_world(const std::string& gravity, const std::string& bodies) {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n" + bodies;
}
std::string rigid_text(const std::string& name, const std::string& shape, const std::string& at,
                       const std::string& keys = "") {
  return "[body." + name + "]\nmodel = \"rigid\"\nshape = " + shape + "\nat = " + at + "\n" + keys;
}
std::string on_ground(const std::string& name, const std::string& keys = "") {
  return "[contact." + name + "-floor]\nbetween = [\"" + name + "\", \"ground\"]\n" + keys;
}
std::string pair_text(const std::string& a, const std::string& b, const std::string& keys = "") {
  return "[contact." + a + "-" + b + "]\nbetween = [\"" + a + "\", \"" + b + "\"]\n" + keys;
}
Vec3d last_force(const World& world, std::size_t contact) {
  return world.coupling.contacts[contact].samples.back().force;
}
double tilt_of(const RigidBody& body) {
  const Quaternion& q = body.state.rotation;
  return 2 * std::atan2(norm(Vec3d{q[1], q[2], q[3]}), std::abs(q[0]));
}

// A box flies into another one that is at rest, off its center: momentum and angular momentum of both stay.
TEST(RigidContact, CollidingBoxes_KeepMomentum) {
  const Exec exec(2);
  const std::string box = "{ box = [0.04, 0.04, 0.02] }";
  World world = organs_world(
      exec,
      rigid_world("[0, 0, 0]", rigid_text("a", box, "[0, 0, 0]", "mass = 0.3\nvelocity = [0.02, 0, 0.3]\n") +
                                   rigid_text("b", box, "[0.012, 0.008, 0.03]", "mass = 0.2\n") +
                                   pair_text("a", "b", "friction = 0.3\n")));
  const RigidBody &a = world.rigid_bodies[0], &b = world.rigid_bodies[1];
  const auto sums = [&] {
    std::pair<Vec3d, Vec3d> sum;
    for (const RigidBody* body : {&a, &b}) {
      const Vec3d p = body->state.velocity * body->model.mass.mass;
      sum.first += p, sum.second += body->state.momentum + cross(body->state.center, p);
    }
    return sum;
  };
  const auto [before, angular_before] = sums();
  advance(exec, world, 30);
  const auto [after, angular_after] = sums();
  std::printf("momentum off by %.2g, angular momentum by %.2g, second has %.3f\n",
              norm(after - before) / norm(before),
              norm(angular_after - angular_before) / (norm(before) * 0.02),
              b.state.velocity.z * b.model.mass.mass / before.z);
  EXPECT_LT(norm(after - before), 1e-9 * norm(before));
  EXPECT_LT(norm(angular_after - angular_before), 1e-3 * 0.02 * norm(before));
  EXPECT_GT(b.state.velocity.z, 0.05);
}

// A ball falls along the parabola, stops at the ground without bouncing, and the ground bears its weight.
TEST(RigidContact, Ball_FallsAndRests) {
  const Exec exec(2);
  World world = organs_world(
      exec, rigid_world("[0, 0, -9.81]",
                        rigid_text("ball", "{ sphere = 0.02 }", "[0.1, 0.2, 0.52]", "density = 1200\n") +
                            on_ground("ball")));
  const RigidBody& ball = world.rigid_bodies[0];
  const double fall = std::sqrt(2 * 0.5 / 9.81);
  advance(exec, world, 18);
  EXPECT_NEAR(ball.state.center.z, 0.52 - 0.5 * 9.81 * 0.3 * 0.3, 1e-9);
  EXPECT_EQ(last_force(world, 0), Vec3d{});
  int landed = 0;
  for (; landed < 60 && last_force(world, 0) == Vec3d{}; landed++) advance(exec, world, 1);
  EXPECT_NEAR(time_of(world), fall, 2 * world.dt);
  advance(exec, world, 30);
  const double weight = ball.model.mass.mass * 9.81;
  EXPECT_NEAR(ball.model.mass.mass, 1200 * 4 / 3.0 * std::numbers::pi * 8e-6, 1e-9);
  EXPECT_NEAR(ball.state.center.z, 0.02, 1e-5);
  EXPECT_LT(norm(last_force(world, 0) - Vec3d{0, 0, weight}), 1e-3 * weight);
  EXPECT_EQ(world.coupling.unsolved, 0);
}

/// Rolling or sliding on a slope along x: acceleration down it, and friction over normal force.
struct OnSlope {
  double acceleration = 0, ratio = 0, spin = 0;
};
OnSlope down_slope(const std::string& shape, double height, double angle, double friction) {
  const Exec exec(2);
  World world = organs_world(
      exec, rigid_world(fmt::format("[{}, 0, {}]", 9.81 * std::sin(angle), -9.81 * std::cos(angle)),
                        rigid_text("body", shape, fmt::format("[0, 0, {}]", height), "mass = 0.3\n") +
                            on_ground("body", fmt::format("friction = {}\n", friction))));
  advance(exec, world, 6);
  const double before = world.rigid_bodies[0].state.velocity.x;
  const int unsolved = world.coupling.unsolved;  // the impact at the beginning
  advance(exec, world, 30);
  const RigidBody& body = world.rigid_bodies[0];
  const Vec3d force = last_force(world, 0);
  EXPECT_EQ(world.coupling.unsolved, unsolved);
  return {(body.state.velocity.x - before) / (30 * world.dt), -force.x / force.z,
          rigid::spin_of(body.model, body.state).y};
}

// A box on a slope stays until tan θ is μ, within 1 %, and then slides with g (sin θ − μ cos θ).
TEST(RigidContact, Slope_BoxSlidesAboveFrictionAngle) {
  constexpr double kFriction = 0.35;
  for (const double factor : {0.99, 1.01, 1.3}) {
    const double angle = std::atan(factor * kFriction);
    const OnSlope found = down_slope("{ box = [0.05, 0.04, 0.02] }", 0.01, angle, kFriction);
    const double expected = std::max(0.0, 9.81 * (std::sin(angle) - kFriction * std::cos(angle)));
    std::printf("tan θ = %.2f μ: %.5f m/s², expected %.5f; friction %.5f\n", factor, found.acceleration,
                expected, found.ratio);
    EXPECT_NEAR(found.acceleration, expected, 1e-3 * 9.81 * std::sin(angle));
    EXPECT_NEAR(found.ratio, std::min(std::tan(angle), kFriction), 1e-3 * kFriction);
  }
}

// A ball rolls with 5/7 g sin θ, a capsule lying across the slope with g sin θ/(1 + J/(m r²)); above the
// angle at which friction lets them slip, a ball slides.
TEST(RigidContact, Slope_BallAndCapsuleRoll) {
  const double angle = 0.3;
  const OnSlope ball = down_slope("{ sphere = 0.03 }", 0.03, angle, 0.5);
  EXPECT_NEAR(ball.acceleration, 5.0 / 7 * 9.81 * std::sin(angle), 0.002 * 9.81);
  EXPECT_NEAR(ball.ratio, 2.0 / 7 * std::tan(angle), 0.005);
  const rigid::MassProperties rod = rigid::mass_of_round({.radius = 0.01, .ends = {{{}, {0, 0.06, 0}}}}, 1);
  const double resistance = std::min({rod.moments.x, rod.moments.y, rod.moments.z}) / (rod.mass * 1e-4);
  const OnSlope capsule = down_slope("{ capsule = [0.01, 0.03] }\nturn = [90, 0, 0]", 0.01, angle, 0.5);
  EXPECT_NEAR(capsule.acceleration, 9.81 * std::sin(angle) / (1 + resistance), 0.002 * 9.81);
  const OnSlope slipping = down_slope("{ sphere = 0.03 }", 0.03, 0.8, 0.1);
  EXPECT_NEAR(slipping.acceleration, 9.81 * (std::sin(0.8) - 0.1 * std::cos(0.8)), 0.005 * 9.81);
  EXPECT_NEAR(slipping.ratio, 0.1, 1e-4);
}

// Three boxes on each other, each a little aside: every contact bears the weight above it.
TEST(RigidContact, Stack_BearsWeights) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      rigid_world("[0, 0, -9.81]",
                  rigid_text("a", "{ box = [0.06, 0.05, 0.02] }", "[0, 0, 0.0101]", "mass = 0.2\n") +
                      rigid_text("b", "{ box = [0.04, 0.04, 0.03] }", "[0.003, 0, 0.0353]", "mass = 0.5\n") +
                      rigid_text("c", "{ sphere = 0.01 }", "[0.001, 0.002, 0.0605]", "mass = 0.1\n") +
                      on_ground("a", "friction = 0.4\n") + pair_text("b", "a", "friction = 0.4\n") +
                      pair_text("c", "b", "friction = 0.4\n")));
  advance(exec, world, 120);
  const double expected[] = {0.8 * 9.81, 0.6 * 9.81, 0.1 * 9.81};
  for (std::size_t n = 0; n < 3; n++) {
    // contacts are in the order of the file's names
    const BodyContact& contact = world.coupling.contacts[n];
    const std::size_t e = contact.name == "a-floor" ? 0 : contact.name == "b-a" ? 1 : 2;
    const Vec3d force = contact.samples.back().force;
    std::printf("%s: %.6f N of %.6f N\n", contact.name.c_str(), force.z, expected[e]);
    EXPECT_LT(norm(force - Vec3d{0, 0, expected[e]}), 1e-3 * expected[e]) << contact.name;
  }
  for (const RigidBody& body : world.rigid_bodies) EXPECT_LT(norm(body.state.velocity), 1e-3) << body.name;
  EXPECT_EQ(world.coupling.unsolved, 0);
}

// A rod on a hinge swings by 150° at the period of the physical pendulum, 4 √(J/(m g d)) K(sin² (θ/2)),
// about any horizontal axis, and keeps its amplitude.
TEST(RigidContact, Pendulum_SwingsAtPeriodOfLargeAmplitude) {
  const Exec exec(2);
  constexpr double kAmplitude = 150 * std::numbers::pi / 180;
  // hanging along −z, then turned about y; the joint is at one end of the box
  const double half = 0.15, d = half;
  const Vec3d at{half * std::sin(-kAmplitude), 0, -half * std::cos(kAmplitude)};
  World world = organs_world(
      exec,
      rigid_world(
          "[0, 0, -9.81]",
          rigid_text("rod", "{ box = [0.02, 0.03, 0.3] }", fmt::format("[{}, {}, {}]", at.x, at.y, at.z),
                     "turn = [0, 150, 0]\nmass = 0.4\n") +
              "[attachment.joint]\nbetween = [\"rod\", \"ground\"]\nat = [[0, -0.01, 0], [0, 0.01, 0]]\n"
              "stiffness = 1e6\n"));
  const double inertia = 0.4 / 12 * (0.02 * 0.02 + 0.3 * 0.3) + 0.4 * d * d;
  const double expected =
      4 * std::sqrt(inertia / (0.4 * 9.81 * d)) * test::elliptic_k(std::pow(std::sin(kAmplitude / 2), 2));
  // times at which it passes the lowest point
  const RigidBody& rod = world.rigid_bodies[0];
  double before = rod.state.center.x, first = 0, last = 0, farthest = 0;
  int crossings = 0;
  for (int n = 0; n < 1200; n++) {
    advance(exec, world, 1);
    const double now = rod.state.center.x;
    if (rod.state.center.z < 0 && now * before < 0) {
      last = (n + before / (before - now)) * world.dt;
      if (crossings++ == 0) first = last;
    }
    before = now;
    if (n > 900) farthest = std::max(farthest, std::acos(-rod.state.center.z / d));
  }
  const double period = 2 * (last - first) / (crossings - 1);
  std::printf("%d crossings, period %.5f s, expected %.5f s; amplitude %.2f° at the end\n", crossings, period,
              expected, farthest * 180 / std::numbers::pi);
  EXPECT_GT(crossings, 10);
  EXPECT_NEAR(period, expected, 0.01 * expected);
  EXPECT_NEAR(farthest, kAmplitude, 0.02);
  EXPECT_LT(std::abs(rod.state.center.y), 1e-6);
  EXPECT_LT(std::abs(norm(rod.state.center) - d), 1e-4);
  EXPECT_EQ(world.coupling.unsolved, 0);
}

// A spring through the center of mass oscillates at √(k/m) and is damped as implicit Euler says.
TEST(RigidContact, FreeBody_KeepsMomentumThroughWorld) {
  const Exec exec(2);
  World world = organs_world(
      exec, rigid_world("[0, 0, 0]", rigid_text("stone", "{ box = [0.02, 0.05, 0.03] }", "[0, 0, 0]",
                                                "mass = 0.1\nspin = [2, 9, -3]\nvelocity = [0.1, 0, 0]\n")));
  const Vec3d momentum = world.rigid_bodies[0].state.momentum;
  const double energy = rigid::kinetic_energy(world.rigid_bodies[0].model, world.rigid_bodies[0].state);
  advance(exec, world, 600);
  const RigidBody& stone = world.rigid_bodies[0];
  EXPECT_LT(norm(stone.state.momentum - momentum), 1e-6 * norm(momentum));
  EXPECT_NEAR(rigid::kinetic_energy(stone.model, stone.state), energy, 1e-6 * energy);
  EXPECT_NEAR(stone.state.center.x, 1.0, 1e-9);
  EXPECT_EQ(stone.samples.size(), 600U);
}

/// Planes around the middle of a block: two fine cells to each side, then cells that grow [m].
std::vector<double> graded(bool is_one_sided) {
  constexpr int kCells = 10;
  constexpr double kFinest = 0.0014, kGrowth = 1.5;
  std::vector<double> planes{0};
  for (int n = 0; n < kCells; n++)
    planes.push_back(planes.back() + kFinest * std::pow(kGrowth, std::max(0, n - 1)));
  std::vector<double> all;
  for (std::size_t n = planes.size(); n-- > 1;) all.push_back(-planes[n]);
  all.push_back(0);
  if (!is_one_sided) all.insert(all.end(), planes.begin() + 1, planes.end());
  return all;
}

/// Writes hexahedra as a legacy VTK file.
void write_hexahedra(const std::filesystem::path& file, const SolidMesh& mesh) {
  std::string text = "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  text += fmt::format("POINTS {} double\n", mesh.vertices.size());
  for (const Vec3d x : mesh.vertices) text += fmt::format("{} {} {}\n", x.x, x.y, x.z);
  const std::size_t count = element_count(mesh);
  text += fmt::format("CELLS {} {}\n", count, 9 * count);
  for (std::size_t e = 0; e < count; e++) {
    text += "8";
    for (const int v : element(mesh, e)) text += fmt::format(" {}", v);
    text += "\n";
  }
  text += fmt::format("CELL_TYPES {}\n", count);
  for (std::size_t n = 0; n < count; n++) text += "12\n";
  ASSERT_TRUE(write_file(file, text));
}

// A rigid ball lies on a wide block of tissue: the block bears its weight, and the ball sinks as Hertz says
// for a half space, F = 4/3 E* √R d^(3/2), under three weights.
TEST(RigidContact, BallOnTissue_SinksAsHertz) {
  const Exec exec(2);
  const std::filesystem::path file = test::fresh_folder() / "block.vtk";
  write_hexahedra(file, hex_block(graded(false), graded(false), graded(true)));
  const double young = 2e4, radius = 0.06, mass = 0.0045;
  const std::string text = rigid_world(
      "[0, 0, -9.81]",
      fmt::format("[body.tissue]\nmodel = \"sfem\"\nmesh = \"{}\"\nscale = 1\nfixed = {{ sides = \"bottom\", "
                  "depth = 0.001 }}\nyoung = {}\npoisson = 0.3\ncache = false\n",
                  file.string(), young) +
          rigid_text("ball", "{ sphere = 0.06 }", "[0, 0, 0.0601]", fmt::format("mass = {}\n", mass)) +
          pair_text("ball", "tissue", "friction = 0\nsites = 200\n"));
  World world = organs_world(exec, text);
  const RigidBody& ball = world.rigid_bodies[0];
  const double effective = young / (1 - 0.09);
  for (const double factor : {0.7, 1.0, 1.5}) {
    world.gravity.z = -9.81 * factor;
    advance(exec, world, 40);
    const double weight = mass * 9.81 * factor;
    const double expected = std::pow(weight / (4.0 / 3 * effective * std::sqrt(radius)), 2.0 / 3);
    const double depth = radius - ball.state.center.z;
    std::printf("depth %.4f mm, Hertz %.4f mm (%.1f %%), contact radius %.2f mm, %d sites\n", 1e3 * depth,
                1e3 * expected, 100 * (depth / expected - 1), 1e3 * std::sqrt(radius * expected),
                world.coupling.contacts[0].samples.back().bearing);
    EXPECT_LT(norm(last_force(world, 0) - Vec3d{0, 0, weight}), 1e-3 * weight);
    EXPECT_NEAR(depth, expected, 0.05 * expected);
  }
  EXPECT_EQ(world.coupling.unsolved, 0);
}

// A box glued to a block of tissue by springs hangs below it with its weight, and turns with what holds it.
TEST(RigidContact, BoxHangsFromTissue) {
  const Exec exec(2);
  World world = organs_world(
      exec,
      rigid_world(
          "[0, 0, -9.81]",
          block_text("tissue", "[0, 0, 0]", "[0.06, 0.06, 0.03]", "[6, 6, 3]", "top", 5e4) +
              rigid_text("box", "{ box = [0.04, 0.04, 0.02] }", "[0.03, 0.03, -0.0105]", "mass = 0.05\n") +
              "[attachment.glue]\nbetween = [\"box\", \"tissue\"]\ndistance = 0.002\nstiffness = 2000\n"));
  advance(exec, world, 240);
  const Attachment& glue = world.coupling.attachments[0];
  EXPECT_GT(glue.ties.size(), 4U);
  EXPECT_LT(norm(glue.samples.back().force - Vec3d{0, 0, 0.05 * 9.81}), 1e-3 * 0.05 * 9.81);
  EXPECT_LT(tilt_of(world.rigid_bodies[0]), 0.01);
}

std::string mixed_scene() {
  return rigid_world(
      "[0, 0, -9.81]",
      block_text("tissue", "[-0.03, -0.03, -0.02]", "[0.06, 0.06, 0.02]", "[6, 6, 2]", "bottom") +
          rigid_text("stone", "{ box = [0.02, 0.03, 0.01] }", "[0, 0, 0.02]",
                     "density = 2000\nturn = [20, 30, 0]\nspin = [3, 0, 5]\n") +
          rigid_text("rod", "{ capsule = [0.004, 0.02] }", "[0.01, 0, 0.035]",
                     "density = 2000\nturn = [90, 0, 0]\n") +
          pair_text("stone", "tissue") + pair_text("rod", "tissue") + pair_text("rod", "stone"));
}

// A tumbling stone and a rod on tissue: the same bits on any number of threads, and after a copy.
TEST(RigidContact, Mixed_SameBits) {
  World world = organs_world(Exec(1), mixed_scene());
  advance(Exec(1), world, 20);
  World copy = copy_of(world);
  advance(Exec(1), world, 20);
  advance(Exec(8), copy, 20);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_TRUE(std::isfinite(world.rigid_bodies[0].state.center.z));
}

// Wrong keys are refused with their location.
TEST(RigidContact, WrongKeys_AreRefused) {
  const auto message = [](const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.toml");
    return scene ? std::string() : scene.error().message;
  };
  const std::string ball = "[body.a]\nmodel = \"rigid\"\nshape = { sphere = 0.01 }\n";
  EXPECT_NE(message(ball).find("density or the mass"), std::string::npos) << message(ball);
  const std::string both = ball + "mass = 1\ndensity = 1000\n";
  EXPECT_NE(message(both).find("not both"), std::string::npos) << message(both);
  const std::string fixed = ball + "mass = 1\nfixed = true\n" + on_ground("a");
  EXPECT_NE(message(fixed).find("neither of the two can move"), std::string::npos) << message(fixed);
  const std::string two =
      "[body.a]\nmodel = \"rigid\"\nmass = 1\nshape = { sphere = 0.01, box = [1, 1, 1] }\n";
  EXPECT_NE(message(two).find("one shape"), std::string::npos) << message(two);
  const std::string tool = ball + "mass = 1\n[tool.t]\nbody = \"a\"\nshape = { sphere = 0.01 }\npress = {}\n";
  EXPECT_NE(message(tool).find("tool.t"), std::string::npos) << message(tool);
}

}  // namespace
}  // namespace turgor
