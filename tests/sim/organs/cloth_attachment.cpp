// Cloth that hangs from bodies of every other kind and from the ground by springs.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::advance;

constexpr double kClothGravity = 9.81;  // [m/s²]

/// A sheet of 60 mm along x and 40 mm along z that hangs below y = -16 mm, with `keys` of its table.
std::string hanging_sheet(const std::string& keys = "") {
  return "[body.sheet]\nmodel = \"cloth\"\nsheet = { corner = [-0.03, -0.016, 0], side = [0.06, 0, 0], up = "
         "[0, -0.04, 0], columns = 12, rows = 8 }\nfabric.density = 0.3\nwind = { density = 0 "
         "}\ndamping.motion = 4\ncollision.self = false\n" +
         keys;
}
/// Springs of its upper edge.
std::string tied(const std::string& other, const std::string& keys = "") {
  return fmt::format(
      "[attachment.glue]\nbetween = [\"sheet\", \"{}\"]\nbox = [[-1, -0.0161, -1], [1, -0.0159, "
      "1]]\ndistance = 0.01\npoints = 60\n{}",
      other, keys.empty() ? "stiffness = 40\n" : keys);
}
std::string world_header(const std::string& gravity = "[0, -9.81, 0]") {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n";
}
std::string fixed_block() {
  return test::block_text("block", "[-0.035, -0.015, -0.02]", "[0.07, 0.03, 0.04]", "[7, 3, 4]", "back");
}
double weight_of(const World& world) { return world.cloth_bodies[0].model.total_mass * kClothGravity; }
Vec3d glue_force(const World& world) { return world.coupling.attachments[0].samples.back().force; }

// A sheet hangs from the ground with its weight, lower by that over the stiffness.
TEST(ClothAttachment, SheetHangsFromGround) {
  const Exec exec(2);
  World world = test::organs_world(exec, world_header() + hanging_sheet() + tied("ground"));
  advance(exec, world, 180);
  const double weight = weight_of(world);
  std::printf("pull %.6f N of %.6f N\n", glue_force(world).y, weight);
  EXPECT_LT(norm(glue_force(world) - Vec3d{0, weight, 0}), 1e-3 * weight);
  // mean stretch of the springs
  double lower = 0;
  const std::vector<Vec3d> moved = support_displacement(world, world.coupling.supports[0]);
  for (const contact::Tie& tie : world.coupling.attachments[0].ties)
    lower -= moved[std::size_t(tie.a.vertex.x)].y * tie.stiffness / 40;
  EXPECT_NEAR(lower, weight / 40, 0.01 * weight / 40);
}

// The other body bears the weight of the sheet, whatever its model.
TEST(ClothAttachment, OtherBodyBearsWeight) {
  const Exec exec(2);
  World world = test::organs_world(exec, world_header() + fixed_block() + hanging_sheet() + tied("block"));
  advance(exec, world, 180);
  const double weight = weight_of(world);
  const Vec3d load = total_force(world.sfem_bodies[0].press->load);
  std::printf("finite elements: pull %.6f, load %.6f N of %.6f N\n", glue_force(world).y, load.y, weight);
  EXPECT_LT(norm(glue_force(world) - Vec3d{0, weight, 0}), 2e-3 * weight);
  EXPECT_LT(norm(load + Vec3d{0, weight, 0}), 2e-3 * weight);
}

// A free rigid body hangs from a sheet, which hangs from the ground: on average both attachments have the
// weights below them.
TEST(ClothAttachment, RigidBodyHangsFromSheet) {
  const Exec exec(2);
  const std::string plate =
      "[body.plate]\nmodel = \"rigid\"\nshape = { box = [0.06, 0.004, 0.01] }\nat = [0, -0.0585, 0]\nmass = "
      "0.05\n";
  World world = test::organs_world(
      exec, world_header() + hanging_sheet() + plate + tied("ground", "stiffness = 200\n") +
                "[attachment.below]\nbetween = [\"plate\", \"sheet\"]\ndistance = 0.002\nstiffness = 40\n");
  // mean over many swings, which do not grow
  advance(exec, world, 60);
  Vec3d above, on_plate;
  double most = 0;
  constexpr int kFrames = 300;
  for (int n = 0; n < kFrames; n++) {
    advance(exec, world, 1);
    above += glue_force(world) / kFrames;
    on_plate += world.coupling.attachments[1].samples.back().force / kFrames;
    most = std::max(most, glue_force(world).y);
  }
  const double weight = weight_of(world), below = 0.05 * kClothGravity;
  std::printf("above %.6f N of %.6f N, below %.6f N of %.6f N, most %.6f N\n", above.y, weight + below,
              on_plate.y, below, most);
  EXPECT_NEAR(above.y, weight + below, 0.03 * (weight + below));
  EXPECT_NEAR(on_plate.y, below, 0.03 * below);
  EXPECT_LT(most, 2.5 * (weight + below));
}

// Springs that are too weak tear, and the sheet falls.
TEST(ClothAttachment, WeakSpringsTear) {
  const Exec exec(2);
  World world = test::organs_world(
      exec, world_header() + hanging_sheet() + tied("ground", "stiffness = 40\nbreak_force = 0.002\n"));
  advance(exec, world, 60);
  for (const contact::Tie& tie : world.coupling.attachments[0].ties) EXPECT_TRUE(tie.broken);
  EXPECT_GT(world.coupling.attachments[0].torn_at, 0);
  EXPECT_LT(world.cloth_bodies[0].state->v[0].y, 0);
}

// Springs that bear ten times their strength all tear within a few frames.
TEST(ClothAttachment, OverloadedSpringsTearAtOnce) {
  const Exec exec(2);
  World world = test::organs_world(exec, world_header() + hanging_sheet() + tied("ground"));
  advance(exec, world, 180);
  std::vector<contact::Tie>& ties = world.coupling.attachments[0].ties;
  ASSERT_GT(ties.size(), 8u);
  for (contact::Tie& tie : ties) tie.strength = 0.1 * norm(tie.force);
  advance(exec, world, 2);
  EXPECT_TRUE(std::all_of(ties.begin(), ties.end(), [](const contact::Tie& tie) { return tie.broken; }));
}

// Springs with slack pull only beyond it.
TEST(ClothAttachment, SlackDelaysPull) {
  const Exec exec(2);
  World world = test::organs_world(
      exec, world_header() + hanging_sheet() + tied("ground", "stiffness = 40\nslack = 0.01\n"));
  advance(exec, world, 2);
  EXPECT_EQ(glue_force(world), Vec3d{});
  advance(exec, world, 240);
  EXPECT_NEAR(glue_force(world).y, weight_of(world), 0.02 * weight_of(world));
}

// The same bits on any number of threads, after a copy and from a state file.
TEST(ClothAttachment, SameBits) {
  const std::string text = world_header() + fixed_block() + hanging_sheet() + tied("block");
  World world = test::organs_world(Exec(1), text), resumed = test::organs_world(Exec(1), text);
  const LoadedPatches loaded = loaded_patches(world);
  advance(Exec(1), world, 10);
  World copy = copy_of(world);
  advance(Exec(1), world, 10);
  advance(Exec(8), copy, 10);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_NE(glue_force(world), Vec3d{});
  test::expect_resumes(Exec(2), test::fresh_folder() / "state.tgs", loaded, world, resumed);
}

// Contact of two cloths is refused.
TEST(ClothAttachment, ContactOfCloths_IsRefused) {
  const std::string second =
      "[body.second]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, 0], "
      "columns = 4, rows = 4 }\n";
  const Result<Scene> scene = parse_scene(
      world_header() + hanging_sheet() + second + "[contact.rest]\nbetween = [\"sheet\", \"second\"]\n",
      "sheet.toml");
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("one mesh file"), std::string::npos) << scene.error().message;
}

}  // namespace
}  // namespace turgor
