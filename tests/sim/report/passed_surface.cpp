#include "turgor/sim/report/passed_surface.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/block_scene.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

using namespace test;

/// A pad of every model, 60 to 130 mm wide and touched from the front, where y is least.
std::vector<std::string> pads(const std::filesystem::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  const std::string block =
      "model = \"sfem\"\nblock = { size = [0.06, 0.06, 0.06], count = [6, 6, 6] }\nfixed = \"back\"\n"
      "cache = false\n";
  return {"[body.pad]\nmodel = \"lattice\"\nct = \"" + (folder / "block.nii").string() +
              "\"\nblock = 2\nfixed = \"bone\"\n",
          "[body.pad]\n" + block,
          "[body.core]\n" + block +
              "[body.pad]\nmodel = \"rhombus\"\nsurface_of = \"core\"\ntissue = \"liver\"\n"};
}

/// The world of a pad after half a second with a ball of this radius [m].
World world_of(const std::string& body, const std::string& motion, double radius = 0.008) {
  const Result<Scene> scene =
      parse_scene("[world]\nduration = 0.5\nframe_rate = 60\ngravity = [0, 0, 0]\n" + body +
                      "[tool.finger]\nbody = \"pad\"\nshape = { sphere = " + std::to_string(radius) + " }\n" +
                      motion + "\n",
                  "s.toml");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  World world = sfem_world(Exec(2), *scene);
  for (int frame = 0; frame < 30; frame++) EXPECT_TRUE(step(Exec(2), world));
  return world;
}

const char* kAtFront = "press = { at_fraction = [0.5, 0, 0.5], start = 0.1, ";

// A tool that shoots through a lattice within two frames causes a warning and has a depth.
TEST(PassedSurface, ShotThroughLatticeIsReported) {
  const World world =
      world_of(pads(fresh_folder())[0], std::string(kAtFront) + "depth = 0.3, duration = 0.03 }");
  const std::optional<SurfacePassage> passage = surface_passage(world, world.tools[0]);
  ASSERT_TRUE(passage);
  EXPECT_NEAR(passage->time, 0.117, 0.02) << "s";
  EXPECT_GT(passage->moved, 0.05) << "m";
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("finger: it moved ")) << warnings[0];
  EXPECT_NE(warnings[0].find("farther than its contact with pad resolves"), std::string::npos) << warnings[0];
}

/// A ball that is pressed out of a torso on the other side. Every step is resolved.
World pressed_through(bool partial) {
  const Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.2\nframe_rate = 240\ngravity = [0, 0, 0]\n[body.torso]\nmodel = \"lattice\"\n"
      "ct = { phantom = \"torso\", size = [40, 32, 20], spacing_mm = [10, 10, 12] }\nblock = 1\n"
      "fixed = [\"bone\", \"ends\"]\n[tool.f]\nbody = \"torso\"\nshape = { sphere = 0.02 }\n"
      "press = { at_fraction = [0.5, 0, 0.5], depth = 0.999, duration = 0.1 }\n",
      "s.toml", {fmt::format("body.torso.tissue.partial_cells={}", partial)});
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  World world = sfem_world(Exec(2), *scene);
  for (int frame = 0; frame < 48; frame++) EXPECT_TRUE(step(Exec(2), world));
  return world;
}

void expect_out_on_other_side(const World& world) {
  const std::optional<SurfacePassage> passage = surface_passage(world, world.tools[0]);
  ASSERT_TRUE(passage);
  EXPECT_EQ(passage->moved, 0) << "no step is longer than contact resolves";
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("f: it passed through the surface of torso at ")) << warnings[0];
}

// A tool that loses its contact on the other side is reported, and one that pushes skin of partial cells out
// there, farther than the body is long.
TEST(PassedSurface, ToolOutOnOtherSideIsReported) {
  for (const bool partial : {false, true}) {
    const World world = pressed_through(partial);
    if (partial) {
      EXPECT_GT(world.tools[0].samples.back().contacts, 0);
    }
    expect_out_on_other_side(world);
  }
}

// Every model reports a tool that a path moves by ten meters in a thousandth of a second.
TEST(PassedSurface, EveryModelReportsJumpOfPath) {
  for (const std::string& body : pads(fresh_folder())) {
    const World world = world_of(body,
                                 "path = [[0, 0.01, -0.2, 0.01], [0.2, 0.01, -0.2, 0.01], [0.201, 0.01, "
                                 "9.8, 0.01]]");
    const std::vector<std::string> warnings = touch_warnings(world);
    ASSERT_EQ(warnings.size(), 1u) << body;
    EXPECT_TRUE(warnings[0].starts_with("finger: it moved 1e+04 mm within ")) << warnings[0];
  }
}

// A tool that jumps into the body is reported, also when it moves less than the body's size.
TEST(PassedSurface, JumpIntoBodyIsReported) {
  for (const std::string& body : pads(fresh_folder())) {
    const World world = world_of(
        body, "path = [[0, 0.01, -0.06, 0.01], [0.2, 0.01, -0.06, 0.01], [0.201, 0.01, 0.01, 0.01]]");
    EXPECT_TRUE(surface_passage(world, world.tools[0])) << body;
  }
}

// A ball that is smaller than the lattice's spacing sinks in between its samples, and is reported.
TEST(PassedSurface, SmallBallThroughLatticeIsReported) {
  const World world =
      world_of(pads(fresh_folder())[0],
               "press = { at_fraction = [0.49, 0, 0.52], start = 0.1, depth = 0.03, duration = 0.3 }", 0.002);
  const std::optional<SurfacePassage> passage = surface_passage(world, world.tools[0]);
  ASSERT_TRUE(passage);
  EXPECT_EQ(passage->moved, 0) << "it did not jump";
  EXPECT_GT(passage->time, 0.15) << "s: after it was a spacing deep";
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u) << "and not that it never touched the body";
  EXPECT_TRUE(warnings[0].starts_with("finger: it passed through the surface of pad at ")) << warnings[0];
}

// A press with a quick retreat is no passage in any model.
TEST(PassedSurface, PressAndRetreat_NoPassage) {
  for (const std::string& body : pads(fresh_folder()))
    for (const char* motion : {"depth = 0.006, duration = 0.2 }", "depth = 0.012, duration = 0.15 }"}) {
      const World world = world_of(body, kAtFront + std::string(motion));
      EXPECT_FALSE(surface_passage(world, world.tools[0])) << body << motion;
      EXPECT_GT(world.tools[0].samples.size(), 0u);
    }
}

// The depth of a lattice's tool is that of its lowest point below the skin at rest, however deep it is.
TEST(PassedSurface, DepthIsThatOfLowestPoint) {
  const World world =
      world_of(pads(fresh_folder())[0], std::string(kAtFront) + "depth = 0.02, duration = 0.2 }");
  double deepest = 0;
  for (const ForceSample& sample : world.tools[0].samples) deepest = std::max(deepest, sample.depth);
  EXPECT_NEAR(deepest, 0.02, 0.001) << "m: more than the ball's diameter below the skin";
}

}  // namespace
}  // namespace turgor
