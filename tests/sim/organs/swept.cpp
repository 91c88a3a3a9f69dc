// Lattices that touch and hold each other, chains and the ground: weights, compression, friction and
// momentum.
#include "turgor/sim/organs/swept.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "swept_blocks.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::advance;
using test::blocks_world;
using test::contact_force;
using test::contact_text;
using test::kBlockGravity;
using test::lattice_text;
using test::load_on;
using test::Whole;
using test::whole_of;
using test::world_text;

World stacked_world(const Exec& exec, double friction) {
  return blocks_world(exec, {{"upper", -0.055}, {"lower", -0.022, true}},
                      world_text("[0, 9.81, 0]") + lattice_text("upper", "none") +
                          lattice_text("lower", "bone", "gravity = false\n") +
                          contact_text("upper", "lower", friction));
}

/// The contact and the load of the lower block are the weight of the upper one, and the surfaces meet within
/// `gap` [m].
void expect_stack_bears_weight(const World& world, double gap) {
  const double weight = whole_of(world, "upper").mass * kBlockGravity;
  std::printf("contact %.5f, load %.5f of %.5f N\n", contact_force(world).y, load_on(world, "lower").y,
              weight);
  EXPECT_LT(norm(contact_force(world) - Vec3d{0, -weight, 0}), 5e-3 * weight);
  EXPECT_LT(norm(load_on(world, "lower") - Vec3d{0, weight, 0}), 5e-3 * weight);
  int bearing = 0;
  for (const contact::PairSite& site : world.coupling.contacts[0].sites)
    if (site.force != Vec3d{}) {
      bearing++;
      EXPECT_LT(std::abs(site.distance), gap);
    }
  EXPECT_GT(bearing, 9);
}

// A free block falls by a millimeter onto a fixed one and lies there. The contact and the load of the lower
// block are its weight, and the surfaces meet.
TEST(Swept, StackedBlocks_BearWeight) {
  const Exec exec(2);
  World world = stacked_world(exec, 0.3);
  advance(exec, world, 150);
  expect_stack_bears_weight(world, 2e-5);
}

// A free block on the ground: it falls, and the ground bears its weight.
TEST(Swept, BlockOnGround_BearsWeight) {
  const Exec exec(2);
  World world = blocks_world(
      exec, {{"block", -0.055}},
      world_text("[0, 9.81, 0]") + lattice_text("block", "none") +
          contact_text("block", "ground", 0.3, "through = [0, -0.021, 0]\nnormal = [0, -1, 0]\n"));
  advance(exec, world, 90);
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  EXPECT_LT(norm(contact_force(world) - Vec3d{0, -weight, 0}), 5e-3 * weight);
}

// A stiff block with few sweeps stays on the ground, which bears at least its weight; it does not jump higher
// in every frame until nothing is finite.
TEST(Swept, StiffBlockOnGround_FewSweepsStayFinite) {
  const Exec exec(2);
  World world = blocks_world(
      exec, {{"block", -0.055}},
      world_text("[0, 9.81, 0]") + lattice_text("block", "none", "tissue.young = 1e5\n") +
          contact_text("block", "ground", 0.3, "through = [0, -0.0225, 0]\nnormal = [0, -1, 0]\n"));
  world.lattice_bodies[0].model.params.solver.sweeps = 5;
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  for (int frame = 0; frame < 90; frame++) ASSERT_TRUE(step(exec, world)) << frame;
  for (int frame = 0; frame < 10; frame++) {
    ASSERT_TRUE(step(exec, world));
    EXPECT_GT(norm(contact_force(world)), 0.8 * weight);
    EXPECT_LT(norm(contact_force(world)), 1.8 * weight);
  }
}

// On sloping ground a block rests below the friction angle, and slides above it with g (sin θ − μ cos θ).
TEST(Swept, SlopingGround_SlidesAboveFrictionAngle) {
  const Exec exec(2);
  constexpr double kFriction = 0.4;
  for (const double factor : {0.8, 1.5}) {
    const double angle = std::atan(factor * kFriction);
    World world = blocks_world(
        exec, {{"block", -0.055}},
        world_text(
            fmt::format("[{}, {}, 0]", kBlockGravity * std::sin(angle), kBlockGravity * std::cos(angle))) +
            lattice_text("block", "none", "tissue.young = 5e4\n") +
            contact_text("block", "ground", kFriction, "through = [0, -0.0229, 0]\nnormal = [0, -1, 0]\n"));
    advance(exec, world, factor < 1 ? 120 : 30);
    const auto speed = [&] {
      const Whole block = whole_of(world, "block");
      return block.momentum.x / block.mass;
    };
    const double before = speed();
    advance(exec, world, 30);
    const double acceleration = (speed() - before) / (30 * world.dt);
    const double expected = std::max(0.0, kBlockGravity * (std::sin(angle) - kFriction * std::cos(angle)));
    const Vec3d force = contact_force(world);
    std::printf("tan = %.1f mu: %.4f m/s2 of %.4f, speed %.4g, friction %.4f of the normal force\n", factor,
                acceleration, expected, before, -force.x / -force.y);
    EXPECT_NEAR(acceleration, expected, 0.02 * kBlockGravity * std::sin(angle));
  }
}

// A free block hangs from a fixed one, and from the ground, by springs. Blocks of whole and of partial cells.
TEST(Swept, HangingBlock_PullsWithWeight) {
  const Exec exec(2);
  for (const auto& [cells, on_ground] :
       {std::pair{"false", false}, {"false", true}, {"true", false}, {"true", true}}) {
    const std::string key = std::string("tissue.partial_cells = ") + cells + "\n";
    const std::string spring =
        on_ground ? "between = [\"block\", \"ground\"]\nbox = [[-1, -0.026, -1], [1, -0.02, 1]]\n"
                  : "between = [\"base\", \"block\"]\ndistance = 0.004\n";
    World world = blocks_world(exec, {{"block", -0.056}, {"base", -0.022, true}},
                               world_text("[0, -9.81, 0]") + lattice_text("block", "none", key) +
                                   lattice_text("base", "bone", "gravity = false\n" + key) +
                                   "[attachment.glue]\n" + spring + "stiffness = 500\npoints = 60\n");
    advance(exec, world, 90);
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    EXPECT_NEAR(std::abs(world.coupling.attachments[0].samples.back().force.y), weight, 5e-3 * weight);
    EXPECT_NEAR(load_on(world, "base").y, on_ground ? 0 : -weight, 5e-3 * weight);
  }
}

// A stiff block hangs off its center, and turns until its weight does. With few sweeps, as with many, the
// springs bear its weight and pull to no side.
TEST(Swept, StiffHangingBlock_FewSweepsBearWeight) {
  const Exec exec(2);
  for (const std::string cells : {"false", "true"}) {
    World world = blocks_world(
        exec, {{"block", -0.056}},
        world_text("[0, -9.81, 0]") +
            lattice_text("block", "none", "stiffness_scale = 4\ntissue.partial_cells = " + cells + "\n") +
            "[attachment.glue]\nbetween = [\"block\", \"ground\"]\nbox = [[-1, -0.026, -1], [0.02, -0.02, "
            "0.02]]\nstiffness = 500\n");
    LatticeBody& block = world.lattice_bodies[0];
    block.model.params.solver.sweeps = 5, block.model.params.solver.damping = 20;
    advance(exec, world, 150);
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    const Vec3d force = world.coupling.attachments[0].samples.back().force;
    std::printf("cells %s: %.5f %.5f %.5f of %.5f N\n", cells.c_str(), force.x, force.y, force.z, weight);
    EXPECT_LT(norm(force - Vec3d{0, weight, 0}), 5e-3 * weight) << cells;
  }
}

/// A block that springs with these keys hold to the ground, at its top.
World hanging_block(const Exec& exec, const std::string& keys) {
  return blocks_world(exec, {{"block", -0.055}},
                      world_text("[0, -9.81, 0]") + lattice_text("block", "none") +
                          "[attachment.glue]\nbetween = [\"block\", \"ground\"]\nbox = [[-1, -0.026, -1], "
                          "[1, -0.02, 1]]\n" +
                          keys);
}

// Many springs, which bear ten times their strength, all tear within a few frames.
TEST(Swept, OverloadedAttachment_TearsAtOnce) {
  const Exec exec(2);
  World world = hanging_block(exec, "stiffness = 5000\npoints = 60\n");
  const std::vector<contact::Tie>& ties = world.coupling.attachments[0].ties;
  ASSERT_GT(ties.size(), 40u);
  advance(exec, world, 90);
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  for (contact::Tie& tie : world.coupling.attachments[0].ties)
    tie.strength = 0.1 * weight / double(ties.size());
  advance(exec, world, 4);
  EXPECT_TRUE(std::all_of(ties.begin(), ties.end(), [](const contact::Tie& tie) { return tie.broken; }));
  EXPECT_GT(world.coupling.attachments[0].torn_at, 0);
}

// Springs that are too weak for the block tear, and it falls.
TEST(Swept, WeakAttachment_Tears) {
  const Exec exec(2);
  World world = hanging_block(exec, "stiffness = 500\npoints = 8\nbreak_force = 0.4\n");
  advance(exec, world, 60);
  for (const contact::Tie& tie : world.coupling.attachments[0].ties) EXPECT_TRUE(tie.broken);
  EXPECT_GT(world.coupling.attachments[0].torn_at, 0);
  EXPECT_LT(whole_of(world, "block").momentum.y, 0);
}

// A free block lies on fixed rigid bodies, a plate or a ball that it is pressed on.
TEST(Swept, BlockOnFixedRigidBody_BearsWeight) {
  const Exec exec(2);
  for (const char* shape : {"{ box = [0.1, 0.02, 0.1] }", "{ sphere = 0.3 }"}) {
    const bool is_box = shape[2] == 'b';
    World world = blocks_world(
        exec, {{"block", -0.055}},
        world_text("[0, 9.81, 0]") + lattice_text("block", "none") +
            fmt::format(
                "[body.base]\nmodel = \"rigid\"\nshape = {}\nat = [0, {}, 0]\nmass = 1\nfixed = true\n",
                shape, is_box ? -0.0115 : 0.279) +
            contact_text("base", "block", 2));
    advance(exec, world, 90);
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    std::printf("%s: %.5f N of %.5f N\n", shape, contact_force(world).y, weight);
    EXPECT_LT(norm(contact_force(world) - Vec3d{0, weight, 0}), 5e-3 * weight);
  }
}

/// The same block with cells of 12 mm, of which those at its faces are partly filled.
std::string partial_text(const std::string& name, const std::string& fixed, const std::string& keys = "") {
  std::string text = lattice_text(name, fixed, "tissue.partial_cells = true\n" + keys);
  const std::string block = "block = 2";
  return text.replace(text.find(block), block.size(), "block = 3");
}

// Blocks with partial cells: a free one falls on a fixed one, which bears its weight; surfaces meet.
TEST(Swept, PartialCells_BearWeight) {
  const Exec exec(2);
  World world = blocks_world(exec, {{"upper", -0.055}, {"lower", -0.022, true}},
                             world_text("[0, 9.81, 0]") + partial_text("upper", "none") +
                                 partial_text("lower", "bone", "gravity = false\n") +
                                 contact_text("upper", "lower", 0.3));
  ASSERT_FALSE(world.lattice_bodies[0].model.anatomy.cell_center.empty());
  advance(exec, world, 150);
  expect_stack_bears_weight(world, 5e-5);
}

// A block with partial cells on the ground with a tool on top: the ground bears both. Contacts of the tool
// and of the ground act in cells together.
TEST(Swept, PartialCells_OnGroundUnderFinger) {
  const Exec exec(2);
  World world = blocks_world(
      exec, {{"block", -0.055}},
      world_text("[0, 9.81, 0]") + partial_text("block", "none") +
          contact_text("block", "ground", 0.3, "through = [0, -0.0225, 0]\nnormal = [0, -1, 0]\n") +
          "[tool.finger]\nbody = \"block\"\nshape = { sphere = 0.012 }\npress = { at_fraction = [0.5, 0, "
          "0.5], depth = 0.006, start = 0.2, duration = 0.3, hold = 9 }\n");
  advance(exec, world, 150);
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  const Vec3d finger = world.tools[0].samples.back().force;
  std::printf("ground %.5f N, weight %.5f N, finger %.5f N\n", contact_force(world).y, weight, finger.y);
  EXPECT_LT(finger.y, -0.03);
  EXPECT_NEAR(contact_force(world).y, -weight + finger.y, 5e-3 * (weight - finger.y));
}

// A block with partial cells hangs from another one by springs.
TEST(Swept, PartialCells_HangByWeight) {
  const Exec exec(2);
  World world = blocks_world(exec, {{"block", -0.056}, {"base", -0.022, true}},
                             world_text("[0, -9.81, 0]") + partial_text("block", "none") +
                                 partial_text("base", "bone", "gravity = false\n") +
                                 "[attachment.glue]\nbetween = [\"base\", \"block\"]\ndistance = "
                                 "0.004\nstiffness = 500\npoints = 60\n");
  advance(exec, world, 90);
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  EXPECT_NEAR(std::abs(world.coupling.attachments[0].samples.back().force.y), weight, 5e-3 * weight);
  EXPECT_NEAR(load_on(world, "base").y, -weight, 5e-3 * weight);
}

// A free block lies on a flat body of chains, which bears its weight. (On the front of a liver, it tips
// over.)
TEST(Swept, BlockOnChains_BearsWeight) {
  const Exec exec(2);
  const std::string slab =
      test::block_text("slab", "[-0.06, 0, -0.06]", "[0.12, 0.06, 0.12]", "[12, 6, 12]", "back") +
      "[body.chains]\nmodel = \"rhombus\"\nsurface_of = \"slab\"\nbulge = 0.4\n";
  for (const bool partial : {false, true}) {
    World world =
        blocks_world(exec, {{"block", -0.033}},
                     world_text("[0, 9.81, 0]") + slab +
                         (partial ? partial_text("block", "none")
                                  : lattice_text("block", "none", "tissue.partial_cells = false\n")) +
                         contact_text("block", "chains", 0.5));
    advance(exec, world, 120);
    Vec3d mean;
    for (int n = 0; n < 30; n++) advance(exec, world, 1), mean += contact_force(world) / 30;
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    std::printf("partial %d: mean force %.4f of %.4f N\n", partial, -mean.y, weight);
    if (partial) {
      EXPECT_NEAR(weight, 64 * 64 * 32 * 900e-9 * kBlockGravity, 1e-4 * weight);
    }
    EXPECT_NEAR(mean.y, -weight, 1e-3 * weight);
  }
}

// A free block, nearly incompressible, rests on the ground with the sweeps of a scene's default. Solved with
// two coarse corrections a step, and started with the friction of the step before, it slid to and fro by a
// quarter of its weight from frame to frame, or bounced.
TEST(Swept, FreeBlockOnGround_RestsWithFewSweeps) {
  const Exec exec(2);
  for (const int cells : {2, 3}) {
    std::string text = partial_text("block", "none");
    const auto set = [&text](const std::string& key, const std::string& value) {
      const std::size_t at = text.find(key) + key.size();
      text.replace(at, text.find('\n', at) - at, value);
    };
    set("block = ", std::to_string(cells)), set("poisson = ", "0.45"), set("sweeps = ", "5");
    World world =
        blocks_world(exec, {{"block", -0.033}},
                     world_text("[0, 9.81, 0]") + text +
                         contact_text("block", "ground", 0.3, "through = [0, 0, 0]\nnormal = [0, -1, 0]\n"));
    advance(exec, world, 120);
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    double sideways = 0, off = 0;
    for (int n = 0; n < 30; n++) {
      advance(exec, world, 1);
      const Vec3d force = contact_force(world);
      sideways = std::max(sideways, std::hypot(force.x, force.z));
      off = std::max(off, std::abs(-force.y - weight));
    }
    std::printf("block of %d: %.4f of the weight off, %.4f sideways\n", cells, off / weight,
                sideways / weight);
    EXPECT_LT(off, 0.01 * weight);
    EXPECT_LT(sideways, 0.01 * weight);
  }
}

// A stack has the same bits on any number of threads, and after a copy.
TEST(Swept, Stack_SameBits) {
  World world = stacked_world(Exec(1), 0.3);
  advance(Exec(1), world, 10);
  World copy = copy_of(world);
  advance(Exec(1), world, 10);
  advance(Exec(8), copy, 10);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_NE(contact_force(world), Vec3d{});
}

// A stack in contact goes on from its state file with the same bits.
TEST(Swept, Stack_ResumesFromFile) {
  const Exec exec(2);
  World world = stacked_world(exec, 0.3), resumed = stacked_world(exec, 0.3);
  const LoadedPatches loaded = loaded_patches(world);
  advance(exec, world, 20);
  ASSERT_NE(contact_force(world), Vec3d{});
  test::expect_resumes(exec, test::fresh_folder() / "state.tgs", loaded, world, resumed);
}

}  // namespace
}  // namespace turgor
