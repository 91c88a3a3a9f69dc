// Attachments in scenes: a block that falls, that hangs, and that tears off; saves, copies and errors.
#include <cmath>

#include "organs_scene.hpp"
#include "turgor/sim/autosave/world_file.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;
using test::block_text;
using test::organs_world;

constexpr const char* kWorld = "[world]\ngravity = [0, 0, -9.81]\nduration = 5\n";

std::string falling(const std::string& more = "") {
  return kWorld + block_text("stone", "[0, 0, 0]", "[0.04, 0.03, 0.02]", "[4, 3, 2]", "none") +
         "density = 1000\n" + more;
}
/// Hangs from the ground by its top face.
std::string hanging(const std::string& more = "") {
  return falling(
      "[attachment.rope]\nbetween = [\"stone\", \"ground\"]\nbox = [[-1, -1, 0.0199], [1, 1, 1]]\n"
      "stiffness = 40\n" +
      more);
}

// Without attachments a free body falls by g h² n (n + 1)/2 in n steps of implicit Euler, and keeps its
// shape. The first frame begins the fall.
TEST(Organs, FreeBody_Falls) {
  const Exec exec(1);
  World world = organs_world(exec, falling());
  constexpr int kSteps = 12;
  advance(exec, world, kSteps + 1);
  const double expected = -9.81 * world.dt * world.dt * kSteps * (kSteps + 1) / 2;
  for (const Vec3d u : world.sfem_bodies[0].flight->u)
    EXPECT_LT(norm(u - Vec3d{0, 0, expected}), 1e-6 * std::abs(expected));
}

// A body that hangs comes to rest with its weight in the attachment, after it has sunk by weight over
// stiffness.
TEST(Organs, HangingBody_WeightInAttachment) {
  const Exec exec(1);
  World world = organs_world(exec, hanging());
  advance(exec, world, 300);
  const double weight = test::mass_of(world.sfem_bodies[0]) * 9.81;
  EXPECT_NEAR(weight, 0.024 * 9.81, 1e-9);
  const Attachment& rope = world.coupling.attachments[0];
  EXPECT_LT(norm(rope.samples.back().force - Vec3d{0, 0, weight}), 1e-3 * weight);
  Vec3d sum, sunk;
  double stiffness = 0;
  for (const contact::Tie& tie : rope.ties) {
    sum += tie.force, stiffness += tie.stiffness;
    sunk += world.sfem_bodies[0].flight->u[std::size_t(tie.a.vertex.x)] * tie.stiffness;
  }
  EXPECT_NEAR(stiffness, 40, 1e-9);
  EXPECT_NEAR(sunk.z / 40, -weight / 40, 1e-3 * weight / 40);

  // the snapshot shows the force in the middle of the tied face, which has sunk
  WorldSnapshot shown;
  show(exec, world, shown);
  ASSERT_EQ(shown.organ_forces.size(), 1u);
  EXPECT_EQ(shown.organ_forces[0].name, "rope");
  EXPECT_LT(norm(shown.organ_forces[0].force - Vec3d{0, 0, weight}), 1e-3 * weight);
  EXPECT_LT(norm(shown.organ_forces[0].at - Vec3d{0.02, 0.015, 0.02 - weight / 40}), 1e-5);
}

// A rod of elements that swings from its end by a quarter turn is linear, and swells: a warning tells so. The
// turn by θ of a linear body strains it by (tan θ)²/2. A rod that hangs still has no warning.
TEST(Organs, TurnedBody_Warns) {
  const Exec exec(1);
  const std::string rod = block_text("rod", "[0, 0, 0]", "[0.08, 0.02, 0.02]", "[8, 2, 2]", "none", 1e5);
  const auto swing = [&](const std::string& box) {
    World world =
        organs_world(exec, kWorld + rod + "[attachment.end]\nbetween = [\"rod\", \"ground\"]\nbox = " + box +
                               "\nstiffness = 1000\n");
    advance(exec, world, 12);
    return std::pair(world.sfem_bodies[0].surface_strain, overstrained(world));
  };
  const auto [turned, warned] = swing("[[-1, -1, -1], [0.0001, 1, 1]]");
  EXPECT_GT(turned, 0.1);
  ASSERT_EQ(warned.size(), 1u);
  EXPECT_NE(warned[0].find("swells"), std::string::npos) << warned[0];
  const auto [straight, silent] = swing("[[-1, -1, 0.0199], [1, 1, 1]]");
  EXPECT_LT(straight, 0.05);
  EXPECT_TRUE(silent.empty());
}

// Two hanging blocks, the lower one tied to the upper one: the attachments bear one weight and two.
TEST(Organs, Chain_WeightsAddUp) {
  const Exec exec(1);
  World world = organs_world(
      exec, hanging(block_text("lower", "[0, 0, -0.022]", "[0.04, 0.03, 0.02]", "[3, 3, 2]", "none") +
                    "density = 2000\n[attachment.link]\nbetween = [\"lower\", \"stone\"]\ndistance = 0.0021\n"
                    "stiffness_per_area = 1e5\n"));
  advance(exec, world, 400);
  const double upper = 0.024 * 9.81, lower = 0.048 * 9.81;
  ASSERT_EQ(world.coupling.attachments.size(), 2u);
  const Attachment &link = world.coupling.attachments[1], &rope = world.coupling.attachments[0];
  EXPECT_NEAR(link.area, 0.04 * 0.03, 1e-9);
  EXPECT_LT(norm(link.samples.back().force - Vec3d{0, 0, lower}), 1e-3 * lower);
  EXPECT_LT(norm(rope.samples.back().force - Vec3d{0, 0, upper + lower}), 1e-3 * (upper + lower));
}

// An attachment that bears more than its strength tears, and the body falls; a stronger one holds.
TEST(Organs, WeakAttachment_Tears) {
  const Exec exec(1);
  for (const auto& [strength, condition] : {std::pair{"0.1", "torn"}, {"2", "intact"}}) {
    World world = organs_world(exec, hanging(std::string("break_force = ") + strength + "\n"));
    advance(exec, world, 60);
    const Json report = Json::parse(json_text(
        simulation_report(exec, test::organs_scene(hanging()), world, make_measures(world), {}), 0));
    EXPECT_EQ(report.at("attachments").at(0).at("condition"), condition);
    EXPECT_EQ(test::mean_displacement(world.sfem_bodies[0]).z < -0.1, condition == std::string("torn"));
  }
}

// A copy, a saved and read world, and a world on other threads continue with the same bits.
TEST(Organs, CopySaveThreads_SameBits) {
  const std::filesystem::path folder = test::fresh_folder();
  const std::string text = hanging("break_force = 0.3\nslack = 0.0005\n");
  World world = organs_world(Exec(1), text);
  const LoadedPatches loaded = loaded_patches(world);
  advance(Exec(1), world, 8);
  // save
  {
    Result<StateWriter> file = StateWriter::create(folder / "state");
    ASSERT_TRUE(file);
    write_world(*file, world, loaded);
    ASSERT_TRUE(file->close());
  }
  World copy = copy_of(world);
  advance(Exec(1), world, 12);
  advance(Exec(2), copy, 12);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  // read
  World read = organs_world(Exec(8), text);
  Result<StateReader> file = StateReader::open(folder / "state");
  ASSERT_TRUE(file);
  read_world(Exec(8), *file, loaded_patches(read), read);
  EXPECT_TRUE(file->is_at_end());
  advance(Exec(8), read, 12);
  EXPECT_EQ(state_hash(read), state_hash(world));
  EXPECT_EQ(read.coupling.attachments[0].samples.size(), world.coupling.attachments[0].samples.size());
}

std::string error_of(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "organs.toml");
  if (!scene) return scene.error().message;
  const Result<World> world = load_world(Exec(1), *scene);
  return world ? "" : world.error().message;
}

// Every mistake has a sentence with its location.
TEST(Organs, Mistakes_AreExplained) {
  const auto attached = [](const std::string& keys) {
    return error_of(falling("[attachment.rope]\n" + keys));
  };
  const auto expect = [](const std::string& error, const std::string& words) {
    EXPECT_NE(error.find(words), std::string::npos) << error;
    EXPECT_NE(error.find("organs.toml:"), std::string::npos) << error;
  };
  expect(attached("between = [\"stone\", \"liver\"]\nstiffness = 1\n"), "the scene has no body liver");
  expect(attached("between = [\"stone\", \"stone\"]\nstiffness = 1\n"), "two different names");
  expect(attached("between = [\"stone\", \"ground\"]\nstiffness = 1\n"), "needs a box");
  expect(attached("between = [\"stone\", \"ground\"]\nbox = [[0,0,0],[1,1,1]]\n"),
         "the stiffness of the springs");
  expect(attached("between = [\"stone\", \"ground\"]\nbox = [[0,0,0.1],[1,1,1]]\nstiffness = 1\n"),
         "contains no surface vertex of stone");
  expect(error_of(falling(block_text("far", "[0, 0, -0.05]", "[0.04, 0.03, 0.02]", "[2, 2, 2]", "bottom") +
                          "[attachment.a]\nbetween = [\"stone\", \"far\"]\nstiffness = 1\n")),
         "the nearest is 0.03 m away");
  expect(error_of(falling(
             "[body.towel]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 1], side = [0.1, 0, 0], up = "
             "[0, 0.1, 0], columns = 3, rows = 3 }\n[contact.a]\nbetween = [\"stone\", "
             "\"towel\"]\n")),
         "towel touches bodies that are its obstacles");
  expect(error_of(falling("rotations = true\n")), "rotations are not computed");
}

}  // namespace
}  // namespace turgor
