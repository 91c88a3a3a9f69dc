// Tools on cloth and their forces.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

/// A sheet of 0.2 m with its first column held; cells are 10 mm.
constexpr const char* kSheet = R"(
[world]
gravity = [0, 0, -9.81]
frame_rate = 60
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0.1, 0], columns = 20, rows = 10 }
fabric = { law = "sheet", density = 0.3 }
solver = { method = "two_level", sweeps = 200 }
damping = { motion = 4 }
collision = { thickness = 0.008 }
wind = { density = 0 }
[body.sheet.hold.left]
box = [[-0.001, -1, -1], [0.001, 1, 1]]
)";

std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Result<Scene> scene = parse_scene(text, "sheet.toml", overrides);
  if (!scene) return scene.error().message;
  const Result<World> world = load_world(Exec(1), *scene);
  return world ? "no error" : world.error().message;
}

std::vector<Vec3d> forces_of_tool(const World& world) {
  std::vector<Vec3d> forces;
  for (const ForceSample& s : world.tools[0].samples) forces.push_back(Vec3d(s.force));
  return forces;
}

/// Mean tool force of the last frames [N].
Vec3d tool_force(const World& world, std::size_t frames) {
  return mean_of_last(forces_of_tool(world), frames);
}

/// Largest change of the tool's force along its mean in the last frames, relative to the mean.
double trembling(const World& world, std::size_t frames) {
  const std::vector<Vec3d> forces = forces_of_tool(world);
  const Vec3d mean = mean_of_last(forces, frames);
  double largest = 0;
  for (std::size_t n = forces.size() - frames; n < forces.size(); n++)
    largest = std::max(largest, std::abs(dot(forces[n] - mean, mean)));
  return largest / dot(mean, mean);
}

Vec3d force_of_holds(const World& world, std::size_t frames) {
  Vec3d sum;
  for (const ClothHold& hold : world.cloth_bodies[0].holds) sum += mean_of_last(hold.force, frames);
  return sum;
}

double weight_of(const World& world) { return world.cloth_bodies[0].model.total_mass * kGravity; }

double longest_edge(const World& world) {
  const ClothBody& body = world.cloth_bodies[0];
  return cloth::largest_stretch(body.model, body.state);
}

// A fixed ball or rod carries the weight that the holds do not carry.
TEST(ClothTools, ToolsAndHoldsShareWeight) {
  struct Case {
    const char *shape, *turn;
    std::vector<std::string> more;
  };
  const std::string springs = "body.sheet.fabric.law=springs";
  for (const auto& [shape, turn, more] :
       {Case{"{ sphere = 0.03 }", "", {}},
        Case{"{ capsule = [0.015, 0.08] }", ", 0, 0.70710678, 0.70710678, 0, 0", {}},
        Case{"{ capsule = [0.015, 0.08] }", ", 0, 0.70710678, 0.70710678, 0, 0", {springs}},
        Case{"{ sphere = 0.02 }", "", {"body.sheet.sheet.columns=13", "body.sheet.sheet.rows=8"}}}) {
    World world =
        must_load(std::string(kSheet) + "[tool.hand]\nbody = \"sheet\"\nfriction = 0.8\nshape = " + shape +
                      "\npath = [[0, 0.08, 0.05, -0.04" + turn + "]]\n",
                  more);
    run(world, 150);
    const double weight = weight_of(world);
    const Vec3d tool = tool_force(world, 30), hold = force_of_holds(world, 30);
    EXPECT_LT(tool.z, -0.3 * weight) << shape;
    EXPECT_NEAR((hold.z - tool.z) / weight, 1, 0.02) << shape;
    EXPECT_NEAR((hold.x - tool.x) / weight, 0, 0.02) << shape << ": equal and opposite";
    EXPECT_NEAR((hold.y - tool.y) / weight, 0, 0.02) << shape;
    EXPECT_LT(longest_edge(world), 1.05) << shape;
  }
}

/// Held on all sides; a ball of 4 mm, smaller than a cell, is pressed 20 mm into its middle.
constexpr const char* kFrame = R"(
[body.sheet.hold.around]
box = [[0.199, -1, -1], [0.201, 1, 1]]
[body.sheet.hold.front]
box = [[-1, -0.001, -1], [1, 0.001, 1]]
[body.sheet.hold.back]
box = [[-1, 0.099, -1], [1, 0.101, 1]]
)";

// A fast ball smaller than a cell does not pass the sheet, and its force equals that of the holds.
TEST(ClothTools, SmallFastBallDoesNotPass) {
  for (const char* law : {"sheet", "springs"})
    for (const char* seconds : {"0.5", "0.02"}) {  // duration of a displacement of 40 mm
      World world =
          must_load(std::string(kSheet) + kFrame +
                        "[tool.ball]\nbody = \"sheet\"\nshape = { sphere = 0.004 }\npath = [[0, 0.103, "
                        "0.052, 0.03], [" +
                        seconds + ", 0.103, 0.052, -0.01]]\n",
                    {std::string("body.sheet.fabric.law=") + law});
      run(world, 100);
      const ClothBody& sheet = world.cloth_bodies[0];
      double lowest = 0;
      for (std::size_t v = 0; v < std::size_t(sheet.model.count); v++)
        lowest = std::min(lowest, double(sheet.state->x.z[v]));
      EXPECT_LT(lowest, -0.012) << seconds;
      const double tool = tool_force(world, 20).z;
      EXPECT_GT(tool, 0.5) << "N: the tool is pushed back";
      EXPECT_NEAR((force_of_holds(world, 20).z - weight_of(world)) / tool, 1, 0.02)
          << law << ", action and reaction; " << seconds;
    }
}

// The friction of a ball that slides over a sheet has Coulomb's ratio to the normal force.
TEST(ClothTools, SlidingBallObeysCoulomb) {
  struct Case {
    const char* path;
    double friction;
    Vec3d direction;
  };
  for (const auto& [path, friction, direction] :
       {Case{"[[0, 0.06, 0.05, 0.02], [0.3, 0.06, 0.05, 0.008], [0.9, 0.14, 0.05, 0.008]]", 0.25, {1, 0, 0}},
        Case{"[[0, 0.12, 0.075, 0.02], [0.3, 0.12, 0.075, 0.01], [0.9, 0.08, 0.025, 0.01]]",
             0.6,
             {-0.62, -0.78, 0}}}) {
    World world = must_load(fmt::format(
        "{}{}[tool.ball]\nbody = \"sheet\"\nfriction = {}\nshape = {{ sphere = 0.012 }}\npath = {}\n", kSheet,
        kFrame, friction, path));
    double friction_impulse = 0, push = 0;
    for (int n = 0; n < 54; n++) {
      run(world, 1);
      if (n < 36) continue;
      for (const cloth::Contact& c : world.cloth_bodies[0].state->contacts.list) {
        if (!(c.impulse > 0) || c.obstacle != 0) continue;
        friction_impulse += double(norm(c.friction_impulse)), push += double(c.impulse);
        EXPECT_LE(norm(c.friction_impulse), 1.001 * friction * double(c.impulse));
      }
    }
    EXPECT_NEAR(friction_impulse / push, friction, 0.02 * friction);
    EXPECT_LT(dot(tool_force(world, 18), direction), 0) << "opposite to the motion";
  }
}

// A ball that rises under a sheet takes over the weight that leaves the table.
TEST(ClothTools, RisingBallUnloadsTable) {
  World world =
      must_load(std::string(kSheet) +
                    "[body.sheet.obstacle.table]\nplane = { through = [0, 0, -0.002] }\nfriction = 0.5\n"
                    "[tool.ball]\nbody = \"sheet\"\nfriction = 0.5\nshape = { sphere = 0.015 }\n"
                    "path = [[0, 0.11, 0.045, -0.02], [0.5, 0.11, 0.045, 0.03]]\n",
                {"body.sheet.hold.left.end=0.01", "body.sheet.fabric.density=0.6"});
  run(world, 150);
  const double weight = weight_of(world), tool = tool_force(world, 30).z,
               table = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 30).z;
  EXPECT_LT(tool, -0.2 * weight) << "N: the ball lifts";
  EXPECT_NEAR((tool + table) / -weight, 1, 0.02) << tool << " N and " << table << " N";
}

// A rod that pushes a hanging sheet has the same lateral force as the holds.
TEST(ClothTools, RodForceEqualsHolds) {
  World world =
      must_load(std::string(kSheet) +
                    "[tool.rod]\nbody = \"sheet\"\nfriction = 0.3\nshape = { capsule = "
                    "[0.01, 0.06] }\npath = [[0, 0.05, 0.05, -0.12], [0.6, 0.05, 0.05, "
                    "-0.12], [1.2, -0.03, 0.06, -0.12]]\n",
                {"body.sheet.sheet={ corner = [0, 0, 0], side = [0, 0.12, 0], up = [0, 0, -0.18], columns = "
                 "11, rows = 15 }",
                 "body.sheet.hold.left.box=[[-1, -1, -0.001], [1, 1, 0.001]]"});
  run(world, 140);
  const Vec3d tool = tool_force(world, 20), hold = force_of_holds(world, 20);
  EXPECT_GT(tool.x, 0.02 * weight_of(world)) << "N: the tool is pushed back";
  EXPECT_NEAR(hold.x / tool.x, 1, 0.02);
  EXPECT_NEAR((hold.z - tool.z) / weight_of(world), 1, 0.02);
}

// The tool force has the same bits on 1, 2 and 8 threads.
TEST(ClothTools, EqualBitsOnAnyThreads) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 8}) {
    World world = must_load(std::string(kSheet) +
                            "[tool.ball]\nbody = \"sheet\"\nshape = { sphere = 0.006 }\n"
                            "path = [[0, 0.1, 0.05, 0.02], [0.2, 0.1, 0.05, -0.02]]\n");
    for (int n = 0; n < 15; n++) ASSERT_TRUE(step(Exec(threads), world));
    if (threads == 1) expected = state_hash(world);
    EXPECT_EQ(state_hash(world), expected) << threads;
  }
}

/// A soft sheet on a soft block.
constexpr const char* kSheetOnPad = R"(
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0.033], side = [0.06, 0, 0], up = [0, 0.06, 0], columns = 12, rows = 12 }
fabric = { law = "sheet", density = 0.3, warp = 20, weft = 20, shear = 5 }
solver = { method = "two_level" }
collision = { thickness = 0.004 }
damping = { motion = 2 }
wind = { density = 0 }
[body.sheet.obstacle.pad]
body = "pad"
)";

// A finger that presses an SFEM body through a sheet has about the force without the sheet, and a steady one.
TEST(ClothTools, PressThroughSheetOnSfem) {
  const std::string path =
      "friction = 0.3\npath = [[0, 0.03, 0.03, 0.045], [0.5, 0.03, 0.03, 0.040], [1.0, 0.03, 0.03, 0.036]]\n";
  // The gaps of sheet and pad, 2 mm each, enlarge the finger.
  const std::vector<std::string> tissue{"body.pad.poisson=0.3"};
  World bare = must_load(
      std::string(kPad) + "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.012 }\n" + path, tissue);
  World world = must_load(std::string(kPad) + kSheetOnPad +
                              "[tool.finger]\nbody = \"sheet\"\nshape = { sphere = 0.008 }\n" + path,
                          tissue);
  run(bare, 70), run(world, 150);
  const double expected = bare.tools[0].samples.back().force.z, weight = weight_of(world);
  const Vec3d tool = tool_force(world, 60), pad = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
  EXPECT_GT(expected, 0.3) << "N";
  EXPECT_NEAR(tool.z, expected, 0.1 * expected) << "N, without the sheet, which spreads the load";
  EXPECT_NEAR(-pad.z, tool.z + weight, 0.02 * tool.z) << "N: the pad carries finger and sheet";
  EXPECT_LT(trembling(world, 60), 0.1);
  const SfemBody& body = world.sfem_bodies[0];
  double sunk = 0;
  for (const Vec3d& u : body.press->displacement) sunk = std::min(sunk, u.z);
  EXPECT_LT(sunk, -0.004) << "m: the pad is pressed down";
}

// A finger presses a lattice through a sheet, and the lattice carries the finger and the sheet.
TEST(ClothTools, PressThroughSheetOnLattice) {
  World world = fat_on_bone(test::fresh_folder(), R"(
tissue = { fat = 5e3 }
[body.sheet]
model = "cloth"
sheet = { corner = [-0.032, -0.022, -0.032], side = [0, 0, 0.064], up = [0.064, 0, 0], columns = 13, rows = 13 }
fabric = { law = "sheet", density = 1, warp = 20, weft = 20, shear = 5 }
solver = { method = "two_level" }
collision = { self = false, thickness = 0.004 }
damping = { motion = 2 }
wind = { density = 0 }
[body.sheet.obstacle.fat]
body = "fat"
[tool.finger]
body = "sheet"
shape = { sphere = 0.012 }
path = [[0, 0, -0.05, 0], [0.5, 0, -0.037, 0], [1.2, 0, -0.033, 0]]
)");
  run(world, 150);
  const Vec3d tool = tool_force(world, 60), fat = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
  EXPECT_LT(tool.y, -0.05) << "N: the tool is pushed back";
  EXPECT_NEAR(fat.y, weight_of(world) - tool.y, 0.02 * fat.y) << "N";
  EXPECT_LT(trembling(world, 60), 0.1);
  EXPECT_LT(longest_edge(world), 1.3);
}

// A finger that presses rhombus chains through a sheet has about the force without the sheet.
TEST(ClothTools, PressThroughSheetOnChains) {
  const std::string chains = std::string(kPad) + "[body.chains]\nmodel = \"rhombus\"\nsurface_of = \"pad\"\n";
  for (const auto& [at, depth] : {std::pair{0.03, 0.003}, {0.026, 0.005}}) {
    const std::string path =
        fmt::format("path = [[0, {0}, 0.03, 0.045], [0.6, {0}, 0.03, {1}]]\n", at, 0.042 - depth);
    // The contact of the finger is 6 mm wide. The gaps of sheet and chains, 2 mm each, enlarge the finger.
    const std::string fine = "body.pad.block={ size = [0.06, 0.06, 0.03], count = [20, 20, 4] }";
    World bare =
        must_load(chains + "[tool.finger]\nbody = \"chains\"\nshape = { sphere = 0.012 }\n" + path, {fine});
    World world = must_load(
        chains + kSheetOnPad + "[tool.finger]\nbody = \"sheet\"\nshape = { sphere = 0.008 }\n" + path,
        {fine, "body.sheet.obstacle.pad.body=chains", "body.sheet.fabric.density=0.1"});
    run(bare, 40), run(world, 80);
    const double expected = bare.tools[0].samples.back().force.z, weight = weight_of(world);
    const Vec3d tool = tool_force(world, 30),
                body = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 30);
    EXPECT_GT(expected, 0.15) << "N";
    EXPECT_NEAR(tool.z, expected, 0.3 * expected) << "N: the sheet and cells of 3 mm spread the load";
    EXPECT_NEAR(-body.z, tool.z + weight, 0.02 * tool.z) << "N: the chains carry finger and sheet";
  }
}

// Forceps are refused on cloth.
TEST(ClothTools, RejectsForceps) {
  EXPECT_NE(
      error_of(std::string(kSheet) + "[tool.jaws]\nbody = \"sheet\"\nshape = { forceps = \"phantom\" }\n"
                                     "path = [[0, 0.1, 0.05, 0.02]]\n")
          .find("forceps do not grasp cloth"),
      std::string::npos);
}

// Tools require the two-level solver; sweeps are refused with a message that names it.
TEST(ClothTools, RejectsSweepSolvers) {
  const std::string error = error_of(std::string(kSheet) +
                                         "[tool.ball]\nbody = \"sheet\"\nshape = { sphere = 0.01 }\n"
                                         "path = [[0, 0.1, 0.05, 0.02]]\n",
                                     {"body.sheet.solver.method=chebyshev"});
  EXPECT_NE(error.find("solver.method = \"two_level\""), std::string::npos) << error;
  EXPECT_NE(error.find("tool.ball"), std::string::npos) << error;
}

}  // namespace
}  // namespace turgor
