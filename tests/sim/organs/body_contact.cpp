// Contact between bodies in scenes: a stack, a block on a slope, and surfaces that do not cross.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "crossing.hpp"
#include "organs_scene.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;
using test::block_text;
using test::organs_world;

std::string touching(const std::string& name, const std::string& a, const std::string& b,
                     const std::string& keys = "") {
  return "[contact." + name + "]\nbetween = [\"" + a + "\", \"" + b + "\"]\n" + keys;
}

// Three blocks on a fixed base: each contact bears the weight of all blocks above it, and no surfaces cross.
TEST(BodyContact, Stack_BearsWeights) {
  const Exec exec(2);
  std::string text =
      "[world]\ngravity = [0, 0, -9.81]\nduration = 5\n" +
      block_text("base", "[-0.01, -0.01, -0.02]", "[0.06, 0.06, 0.02]", "[5, 5, 2]", "bottom", 1e5);
  const char* corners[] = {"[0, 0, 0.001]", "[0.002, 0.001, 0.022]", "[0.001, 0.003, 0.043]"};
  const char* below[] = {"base", "a", "b"};
  const char* names[] = {"a", "b", "c"};
  for (int n = 0; n < 3; n++)
    text += block_text(names[n], corners[n], "[0.04, 0.04, 0.02]", "[4, 4, 2]", "none", 1e5) +
            "density = 1000\n" +
            touching(std::string("on_") + below[n], names[n], below[n], "friction = 0.3\ngap = 0.0003\n");
  World world = organs_world(exec, text);
  advance(exec, world, 240);
  EXPECT_EQ(world.coupling.unsolved, 0);
  const double weight = 0.032 * 9.81;
  for (const BodyContact& contact : world.coupling.contacts) {
    const int above = contact.name == "on_base" ? 3 : contact.name == "on_a" ? 2 : 1;
    const Vec3d force = contact.samples.back().force;
    std::printf("%s: %.6f N of %.6f N, sideways %.2g N\n", contact.name.c_str(), force.z, above * weight,
                std::hypot(force.x, force.y));
    EXPECT_LT(norm(force - Vec3d{0, 0, above * weight}), 1e-3 * above * weight) << contact.name;
    EXPECT_EQ(contact.dropped_most, 0);
    EXPECT_EQ(test::crossing_count(world.sfem_bodies[std::size_t(contact.body[0])],
                                   world.sfem_bodies[std::size_t(contact.body[1])]),
              0);
  }
}

// A weight squashes a pad that no tool touches. Under uniform pressure without lateral strain the pad is
// shorter by e = weight/(E A), and Green's strain of its sides is e − e²/2. A report warns of it above a
// tenth.
TEST(BodyContact, SquashedPad_StrainIsReported) {
  const Exec exec(1);
  for (const double mass : {0.1, 1.2}) {
    World world = organs_world(
        exec,
        "[world]\ngravity = [0, 0, -9.81]\nduration = 5\n[body.pad]\nmodel = \"sfem\"\nblock = { size = "
        "[0.04, 0.04, 0.02], count = [4, 4, 2] }\nfixed = { sides = \"bottom\", depth = 0 }\nyoung = 2e4\n"
        "poisson = 0\ncache = false\n[body.weight]\nmodel = \"rigid\"\nshape = { box = [0.05, 0.05, 0.01] "
        "}\nat = [0.02, 0.02, 0.02501]\n" +
            fmt::format("mass = {}\n", mass) + touching("press", "weight", "pad", "friction = 0.5\n"));
    advance(exec, world, 100);
    world.sfem_bodies[0].surface_strain = 0;  // the weight came suddenly, which strains more
    advance(exec, world, 1);
    const double e = mass * 9.81 / (2e4 * 0.04 * 0.04), expected = e - e * e / 2;
    EXPECT_NEAR(world.sfem_bodies[0].surface_strain, expected, 0.01 * expected);
    EXPECT_EQ(overstrained(world).size(), expected > 0.1 ? 1u : 0u);
  }
}

/// A block on a wide base under gravity that is tilted by an angle [rad]: displacement down the slope after
/// some frames [m].
World on_slope(const Exec& exec, double angle, double friction, int frames) {
  World world = organs_world(
      exec,
      fmt::format("[world]\ngravity = [{}, 0, {}]\nduration = 5\n", 9.81 * std::sin(angle),
                  -9.81 * std::cos(angle)) +
          block_text("base", "[-0.01, -0.01, -0.02]", "[0.2, 0.06, 0.02]", "[10, 3, 1]", "bottom", 1e6) +
          block_text("block", "[0, 0, 0]", "[0.04, 0.04, 0.02]", "[4, 4, 2]", "none", 1e5) +
          "density = 1000\n" + touching("slope", "block", "base", fmt::format("friction = {}\n", friction)));
  advance(exec, world, frames);
  return world;
}

// A block on a slope rests while the slope is below the friction angle, with friction that balances it, and
// slides above it with the acceleration g (sin θ − μ cos θ).
TEST(BodyContact, Slope_SlidesAboveFrictionAngle) {
  const Exec exec(2);
  constexpr double kFriction = 0.4;
  for (const double factor : {0.9, 1.25, 1.5}) {
    const double angle = std::atan(factor * kFriction);
    constexpr int kSettle = 6, kFrames = 16;
    World world = on_slope(exec, angle, kFriction, kSettle);
    const auto speed = [&] {
      const SfemBody& block = world.sfem_bodies[0].flight ? world.sfem_bodies[0] : world.sfem_bodies[1];
      Vec3d sum;
      for (std::size_t v = 0; v < block.flight->v.size(); v++)
        sum += block.flight->v[v] * block.model.mass[v];
      return sum.x / test::mass_of(block);
    };
    const double before = speed();
    advance(exec, world, kFrames);
    const double acceleration = (speed() - before) / (kFrames * world.dt);
    const double expected = std::max(0.0, 9.81 * (std::sin(angle) - kFriction * std::cos(angle)));
    const Vec3d force = world.coupling.contacts[0].samples.back().force;
    std::printf("tan θ = %.2f μ: %.4f m/s², expected %.4f; friction %.4f of the normal force\n", factor,
                acceleration, expected, -force.x / force.z);
    EXPECT_NEAR(acceleration, expected, 0.02 * 9.81 * std::sin(angle));
    EXPECT_NEAR(-force.x / force.z, std::min(std::tan(angle), kFriction), 0.02 * kFriction);
  }
}

/// Momentum of a body in the latest frame [kg m/s].
Vec3d block_momentum(const SfemBody& body) {
  Vec3d sum;
  for (std::size_t v = 0; v < body.flight->v.size(); v++) sum += body.flight->v[v] * body.model.mass[v];
  return sum;
}

// A free block flies into another one that is at rest, off its center: the momentum of both stays, and the
// second one has got more than a third of it.
TEST(BodyContact, CollidingBlocks_KeepMomentum) {
  const Exec exec(2);
  World world = organs_world(
      exec, "[world]\nduration = 5\n" +
                block_text("a", "[0, 0, 0]", "[0.04, 0.04, 0.02]", "[4, 4, 2]", "none", 5e4) +
                block_text("b", "[0.006, 0.004, 0.025]", "[0.04, 0.04, 0.02]", "[4, 4, 2]", "none", 5e4) +
                touching("hit", "a", "b", "friction = 0.3\n"));
  const bool a_first = world.sfem_bodies[0].name == "a";
  SfemBody &a = world.sfem_bodies[a_first ? 0 : 1], &b = world.sfem_bodies[a_first ? 1 : 0];
  // velocity by the displacement a frame ago
  for (Vec3d& u : a.flight->u) u -= Vec3d{0.02, 0, 0.1} * world.dt;
  advance(exec, world, 1);
  const Vec3d before = block_momentum(a) + block_momentum(b);
  EXPECT_NEAR(before.z, 0.1 * test::mass_of(a), 1e-3 * before.z);
  int touched = 0;
  double most = 0;
  for (int n = 0; n < 40; n++) {
    advance(exec, world, 1);
    touched += world.coupling.contacts[0].samples.back().bearing > 0;
    most = std::max(most, norm(block_momentum(a) + block_momentum(b) - before) / norm(before));
  }
  std::printf("momentum off by %.2g, second has %.3f of it, touched for %d frames\n", most,
              block_momentum(b).z / before.z, touched);
  EXPECT_LT(most, 1e-9);
  EXPECT_GT(touched, 0);
  EXPECT_GT(block_momentum(b).z, before.z / 3);
}

std::string pressed_pad() {
  return "[world]\nduration = 3\n" +
         block_text("base", "[-0.01, -0.01, -0.02]", "[0.08, 0.08, 0.02]", "[7, 7, 2]", "bottom") +
         block_text("pad", "[0, 0, 0]", "[0.06, 0.06, 0.015]", "[6, 6, 2]", "none") +
         touching("below", "pad", "base") +
         "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.008 }\nfriction = 0\n"
         "press = { at_fraction = [0.45, 0.55, 1], depth = 0.003, start = 0, duration = 0.1, hold = 3 }\n";
}

// A finger presses a loose pad on a base: at rest the base bears the force that the finger feels, although
// ticks and frames exchange their forces in turn.
TEST(BodyContact, PressedPad_BaseBearsFinger) {
  const Exec exec(2);
  World world = organs_world(exec, pressed_pad());
  advance(exec, world, 120);
  const Vec3d finger = world.tools[0].samples.back().force;
  const Vec3d base = world.coupling.contacts[0].samples.back().force;
  std::printf("finger %.5f N, base %.5f N\n", finger.z, base.z);
  EXPECT_GT(finger.z, 0.05);
  EXPECT_LT(norm(base - finger), 1e-3 * finger.z);
}

// Ticks, frames and contacts have the same bits on any number of threads, and after a copy.
TEST(BodyContact, PressedPad_SameBits) {
  World world = organs_world(Exec(1), pressed_pad());
  advance(Exec(1), world, 9);
  World copy = copy_of(world);
  advance(Exec(1), world, 9);
  advance(Exec(8), copy, 9);
  EXPECT_EQ(state_hash(copy), state_hash(world));
}

}  // namespace
}  // namespace turgor
