// The default of cells at the surface of a lattice body.
#include "turgor/sim/scene/scene_cells.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

constexpr const char* kBodyOfCells = "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n";

LatticeScene scene_of_cells(const std::string& lines, const std::string& world = "") {
  const Result<Scene> scene = parse_scene(world + kBodyOfCells + lines, "s.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return scene->lattice_bodies[0];
}

// A solid body has partial cells on either device, and a scene may choose.
TEST(SceneCells, PartialCellsAreTheDefault) {
  for (const char* lines : {"", "skin = false\n", "tissue = \"liver\"\n", "skin = { tension = 60 }\n"})
    for (const char* world : {"", "[world]\ndevice = \"gpu\"\n"}) {
      const LatticeScene scene = scene_of_cells(lines, world);
      EXPECT_TRUE(scene.params.tissue.partial_cells) << world << lines;
      EXPECT_EQ(cells_text(scene), "partial");
    }
  const LatticeScene whole = scene_of_cells("tissue = { partial_cells = false }\n");
  EXPECT_FALSE(whole.params.tissue.partial_cells);
  EXPECT_EQ(cells_text(whole), "whole, as the scene says");
  EXPECT_EQ(cells_text(scene_of_cells("tissue = { partial_cells = true }\n")), "partial, as the scene says");
}

// A body that does not support them has whole cells, with the reason.
TEST(SceneCells, UnsupportedBodyHasWholeCellsWithReason) {
  for (const auto& [lines, reason] : std::vector<std::pair<std::string, std::string>>{
           {"tissue = { law = \"springs\" }\n", "its springs join whole nodes"},
           {"solver = { method = \"pbd\" }\nskin = { law = \"area\" }\n", "its springs join whole nodes"},
           {"tissue = { law = \"exponential\", stiffening = 8 }\n", "its tissue stiffens"},
           {"layers = [{ name = \"fat\", thickness = 0.01, young = 3e3 }, { name = \"m\", young = 1e4 }]\n",
            "it has layers"},
           {"viscosity = { ratio = 0.5, time = 0.1 }\n", "its tissue relaxes"},
           {"permanent_set = { share = 0.5 }\n", "its tissue keeps a permanent set"},
           {"skin = { law = \"area\" }\n", "its skin has the law \"area\""},
           {"skin = { law = \"exponential\" }\n", "its skin stiffens"}}) {
    const LatticeScene scene = scene_of_cells(lines);
    EXPECT_FALSE(scene.params.tissue.partial_cells) << lines;
    EXPECT_EQ(cells_text(scene), "whole, since " + reason);
  }
}

// A tool touches whole cells on a GPU, and partial ones on the CPU.
TEST(SceneCells, ToolOnGpuNeedsWholeCells) {
  const std::string tool =
      "[tool.hook]\nbody = \"b\"\nshape = { sphere = 0.01 }\npress = { at_fraction = [0.5, 0, 0.5], depth = "
      "0.002 }\n";
  EXPECT_EQ(cells_text(scene_of_cells(tool)), "partial");
  EXPECT_EQ(cells_text(scene_of_cells(tool, "[world]\ndevice = \"gpu\"\n")),
            "whole, since tool.hook touches it on a GPU");
}

// A body that a needle enters has whole cells: partial ones miss its work by 14 % in needle-ct.toml.
TEST(SceneCells, NeedleNeedsWholeCells) {
  EXPECT_EQ(cells_text(scene_of_cells(
                "[tool.pin]\nbody = \"b\"\nshape = { needle = 0.1, diameter = 0.001, toughness = 100 "
                "}\npress = { at_fraction = [0.5, 0, 0.5], depth = 0.002 }\n")),
            "whole, since tool.pin is a needle");
}

// Lattices that touch other bodies have partial cells: whole ones weigh too little.
TEST(SceneCells, ContactKeepsPartialCells) {
  const std::string bodies =
      "[body.ball]\nmodel = \"rigid\"\nshape = { sphere = 0.01 }\nmass = 0.1\n[body.liver]\nmodel = "
      "\"rhombus\"\nsurface = { phantom = \"liver\" }\n[body.c]\nmodel = \"lattice\"\nct = { phantom = "
      "\"leg\" }\n";
  for (const std::string other : {"ground", "ball", "liver", "c"})
    EXPECT_EQ(cells_text(scene_of_cells(bodies + "[contact.rest]\nbetween = [\"b\", \"" + other + "\"]\n")),
              "partial")
        << other;
}

// Recordings that store no cells mean whole cells where the scene does not choose.
TEST(SceneCells, OlderRecordingMeansWholeCells) {
  for (const bool chooses : {false, true}) {
    Result<Scene> scene =
        parse_scene(std::string(kBodyOfCells) + (chooses ? "tissue.partial_cells = true\n" : ""), "s.toml");
    ASSERT_TRUE(scene);
    use_whole_cells(*scene);
    EXPECT_EQ(scene->lattice_bodies[0].params.tissue.partial_cells, chooses);
    EXPECT_EQ(cells_text(scene->lattice_bodies[0]),
              chooses ? "partial, as the scene says" : "whole, since its recording has them");
  }
}

}  // namespace
}  // namespace turgor
