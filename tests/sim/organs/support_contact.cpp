// Lattices and chains that bodies of finite elements and rigid bodies touch and hold: weights, reactions,
// friction, and what a tool feels through a body that lies on a lattice.
#include <cmath>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "turgor/sim/report/report_organs.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::advance;
using test::block_text;

/// A block of voxels of 4 mm in air, 64 mm wide along x and z: 32 mm of fat on bone along y.
CtVolume fat_ct() {
  CtVolume ct;
  ct.grid.size = {24, 20, 24};
  ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = {-0.046, -0.036, -0.046};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  for (int k = 4; k < 20; k++)
    for (int j = 4; j < 16; j++)
      for (int i = 4; i < 20; i++) ct.at(i, j, k) = j < 12 ? -100 : 1000;
  return ct;
}

/// A block of 32 mm of fat on bone, fixed there. Its front is at y = -22 mm; gravity pulls along y.
std::string fat_text(const std::string& gravity) {
  return "[world]\nduration = 20\ngravity = " + gravity +
         "\n[body.fat]\nmodel = \"lattice\"\nct = \"fat.nii\"\nblock = 2\nfixed = \"bone\"\ngravity = "
         "false\n";
}
World fat_world(const Exec& exec, const std::string& bodies, const std::string& gravity = "[0, 9.81, 0]") {
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "fat.nii", fat_ct()));
  const Result<Scene> scene = parse_scene(fat_text(gravity) + bodies, folder / "fat.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}
std::string stone_on_fat(const std::string& shape, const std::string& at, double mass, double friction) {
  return fmt::format(
      "[body.stone]\nmodel = \"rigid\"\nshape = {}\nat = {}\nmass = {}\n[contact.rest]\nbetween = "
      "[\"stone\", "
      "\"fat\"]\nfriction = {}\n",
      shape, at, mass, friction);
}
/// Sum of the loads on the lattice.
Vec3d load_on_fat(const World& world) { return total_force(world.lattice_bodies[0].cloth); }
Vec3d force_of(const World& world) { return world.coupling.contacts[0].samples.back().force; }

// A lattice that nothing fixes is not stable on elements while the ground also acts on it; the report warns
// of that.
TEST(SupportContact, FreeLatticeOnElementsIsWarnedOf) {
  const Exec exec(1);
  const fs::path folder = test::fresh_folder();
  ASSERT_TRUE(write_ct(folder / "fat.nii", fat_ct()));
  struct Case {
    std::string fixed;
    bool on_ground;
  };
  for (const auto& [fixed, on_ground] : {Case{"bone", false}, {"none", false}, {"none", true}}) {
    std::string text = fat_text("[0, 0, 0]");
    text.replace(text.find("\"bone\""), 6, "\"" + fixed + "\"");
    text += block_text("pad", "[-0.03, -0.06, -0.03]", "[0.06, 0.03, 0.06]", "[3, 2, 3]", "front");
    text += "[contact.rest]\nbetween = [\"pad\", \"fat\"]\n";
    if (on_ground)
      text +=
          "[contact.below]\nbetween = [\"fat\", \"ground\"]\nthrough = [0, 0.04, 0]\nnormal = [0, -1, 0]\n";
    const Result<Scene> scene = parse_scene(text, folder / "fat.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    const Result<World> world = load_world(exec, *scene);
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ(coupling_warnings(*world).size(), on_ground ? 1u : 0u);
  }
}

// A stone falls on a lattice and lies there, on whole and on partial cells: the contact bears its weight, and
// the lattice bears the contact.
TEST(SupportContact, StoneOnLattice_WeightArrives) {
  const Exec exec(2);
  for (const bool is_partial : {false, true}) {
    World world = fat_world(
        exec, fmt::format("tissue.partial_cells = {}\n", is_partial) +
                  stone_on_fat("{ box = [0.03, 0.02, 0.04] }", "[0.005, -0.036, 0.003]", 0.05, 0.3));
    EXPECT_EQ(world.coupling.supports[0].cell.empty(), !is_partial);
    advance(exec, world, 30);
    const double early = world.rigid_bodies[0].state.center.y;
    advance(exec, world, 150);
    const RigidBody& stone = world.rigid_bodies[0];
    const double weight = 0.05 * 9.81;
    const Vec3d force = force_of(world), load = load_on_fat(world);
    std::printf("contact %.6f N, lattice %.6f N of %.6f N; from %.3f to %.3f mm, %.2g mm/s\n", force.y,
                load.y, weight, 1e3 * early, 1e3 * stone.state.center.y, 1e3 * norm(stone.state.velocity));
    EXPECT_LT(norm(force - Vec3d{0, -weight, 0}), 1e-3 * weight);
    EXPECT_LT(norm(load + force), 1e-3 * weight);
    EXPECT_LT(norm(stone.state.velocity), 1e-4);
    EXPECT_GT(stone.state.center.y, -0.0315) << "it sinks into the fat";
  }
}

// On a slope, friction balances a stone below the friction angle; above it the stone slides.
TEST(SupportContact, Slope_SlidesAboveFrictionAngle) {
  const Exec exec(2);
  for (const double factor : {0.7, 1.6}) {
    const double angle = std::atan(factor * 0.4);
    World world =
        fat_world(exec, stone_on_fat("{ box = [0.04, 0.012, 0.04] }", "[-0.02, -0.0261, 0]", 0.02, 0.4),
                  fmt::format("[{}, {}, 0]", 9.81 * std::sin(angle), 9.81 * std::cos(angle)));
    advance(exec, world, factor < 1 ? 180 : 12);
    const Vec3d force = force_of(world);
    const double ratio = -force.x / -force.y;
    std::printf("tan = %.2f mu: friction %.4f of the normal force, %.4f m/s\n", factor, ratio,
                world.rigid_bodies[0].state.velocity.x);
    EXPECT_NEAR(ratio, factor < 1 ? std::tan(angle) : 0.4, 0.02);
    if (factor > 1) {
      EXPECT_GT(world.rigid_bodies[0].state.velocity.x, 0.1);
    } else {
      EXPECT_LT(norm(world.rigid_bodies[0].state.velocity), 1e-3);
    }
  }
}

std::string pad_on_fat() {
  return block_text("pad", "[-0.03, -0.036, -0.03]", "[0.06, 0.015, 0.06]", "[4, 2, 4]", "none") +
         "density = 1000\n[contact.below]\nbetween = [\"fat\", \"pad\"]\nfriction = 0.2\n"
         "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.008 }\nfriction = 0\n"
         "press = { at_fraction = [0.5, 0, 0.5], depth = 0.004, start = 0.2, duration = 0.3, hold = 9 }\n";
}

// A finger presses a loose pad of finite elements on a lattice of whole or partial cells: the lattice bears
// the finger.
TEST(SupportContact, PadOnLattice_BearsFinger) {
  const Exec exec(2);
  for (const bool is_partial : {false, true}) {
    World world =
        fat_world(exec, fmt::format("tissue.partial_cells = {}\n", is_partial) + pad_on_fat(), "[0, 0, 0]");
    advance(exec, world, 150);
    const Vec3d finger = world.tools[0].samples.back().force, force = force_of(world),
                load = load_on_fat(world);
    std::printf("finger %.5f N, on the lattice %.5f N, its load %.5f N\n", finger.y, force.y, load.y);
    EXPECT_LT(finger.y, -0.03);
    EXPECT_LT(norm(force + finger), 2e-3 * norm(finger));
    EXPECT_LT(norm(load - force), 1e-3 * norm(finger));
    EXPECT_EQ(world.coupling.unsolved, 0);
  }
}

// A block of finite elements hangs from a lattice by an attachment, with its weight.
TEST(SupportContact, BlockHangsFromLattice) {
  const Exec exec(2);
  World world =
      fat_world(exec,
                block_text("weight", "[-0.02, -0.037, -0.02]", "[0.04, 0.015, 0.04]", "[3, 1, 3]", "none") +
                    "density = 1000\n[attachment.glue]\nbetween = [\"weight\", \"fat\"]\ndistance = "
                    "0.006\nstiffness = 500\n",
                "[0, -9.81, 0]");
  advance(exec, world, 180);
  const double weight = 1000 * 0.04 * 0.04 * 0.015 * 9.81;
  const Vec3d force = world.coupling.attachments[0].samples.back().force, load = load_on_fat(world);
  std::printf("attachment %.6f N, lattice %.6f N of %.6f N\n", force.y, load.y, weight);
  EXPECT_LT(norm(force - Vec3d{0, weight, 0}), 1e-3 * weight);
  EXPECT_LT(norm(load + force), 1e-3 * weight);
}

// A ball lies on a body of chains, which bears its weight.
TEST(SupportContact, BallOnChains_WeightArrives) {
  const Exec exec(2);
  const std::string liver =
      "[world]\nduration = 20\ngravity = [0, 9.81, 0]\n[body.liver]\nmodel = \"rhombus\"\nsurface = { "
      "phantom = "
      "\"liver\", detail = 0.3 }\nbulge = 0.4\n";
  Vec3d front{0, HUGE_VAL, 0};
  const World alone = test::organs_world(exec, liver);
  for (const Vec3d x : alone.rhombus_bodies[0].model.surface.vertices)
    if (x.y < front.y) front = x;
  World world = test::organs_world(
      exec, liver + fmt::format(
                        "[body.stone]\nmodel = \"rigid\"\nshape = {{ sphere = 0.02 }}\nat = [{}, {}, "
                        "{}]\nmass = 0.03\n[contact.rest]\nbetween = [\"stone\", \"liver\"]\nfriction = 2\n",
                        front.x, front.y - 0.021, front.z));
  advance(exec, world, 40);
  double mean = 0;
  for (int n = 0; n < 100; n++) advance(exec, world, 1), mean += force_of(world).y / 100;
  const Vec3d at = world.rigid_bodies[0].state.center;
  std::printf("mean force %.5f N of %.5f N, %.4f m from the front, %.4f m/s\n", mean, -0.03 * 9.81,
              norm(at - front), norm(world.rigid_bodies[0].state.velocity));
  EXPECT_NEAR(mean, -0.03 * 9.81, 0.03 * 0.03 * 9.81);
}

// A pad on a lattice has the same bits on any number of threads, and after a copy.
TEST(SupportContact, PadOnLattice_SameBits) {
  World world = fat_world(Exec(1), pad_on_fat());
  advance(Exec(1), world, 20);
  World copy = copy_of(world);
  advance(Exec(1), world, 20);
  advance(Exec(8), copy, 20);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_NE(force_of(world), Vec3d{});
}

TEST(SupportContact, WrongPairs_AreRefused) {
  const auto message = [](const std::string& text) {
    const Result<Scene> scene = parse_scene(fat_text("[0, 0, 0]") + text, "fat.toml");
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_NE(
      message("[body.sheet]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, "
              "0.1, 0], columns = 4, rows = 4 }\n[contact.rest]\nbetween = [\"sheet\", \"fat\"]\n")
          .find("body.sheet.obstacle"),
      std::string::npos);
}

}  // namespace
}  // namespace turgor
