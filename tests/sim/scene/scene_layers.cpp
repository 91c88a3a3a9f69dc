// Laws that stiffen, layers and relaxation of lattice bodies in scenes.
#include "turgor/sim/scene/scene_layers.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

constexpr const char* kLayered = "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n";

LatticeScene layered_scene(const std::string& lines) {
  return parse_scene(kLayered + lines, "s.toml")->lattice_bodies[0];
}
std::string layered_error(const std::string& lines, const std::string& world = "") {
  return test::error_of(world + kLayered + lines);
}

// The law and its stiffening are read; ogden takes its exponent from a preset.
TEST(SceneLayers, ReadsLaws) {
  const lattice::TissueParams plain = layered_scene("").params.tissue;
  EXPECT_EQ(plain.energy, lattice::SolidEnergy::kNeoHookean);
  EXPECT_FALSE(lattice::has_cell_laws(plain));
  const lattice::TissueParams stiff =
      layered_scene("tissue = { law = \"exponential\", stiffening = 8, young = 2e4 }\n").params.tissue;
  EXPECT_EQ(stiff.law, lattice::TissueLaw::kSolid);
  EXPECT_EQ(stiff.energy, lattice::SolidEnergy::kExponential);
  EXPECT_EQ(stiff.stiffening, 8);
  const lattice::TissueParams brain =
      layered_scene("tissue = { preset = \"brain-cortex\", law = \"ogden\" }\n").params.tissue;
  EXPECT_EQ(brain.energy, lattice::SolidEnergy::kOgden);
  EXPECT_EQ(brain.stiffening, -18.7);
  EXPECT_EQ(brain.muscle, 4390);
}

// Fibers of a tissue and of layers are read; layers without their own have those of the body.
TEST(SceneLayers, ReadsFibers) {
  const LatticeScene scene = layered_scene(
      "tissue = { law = \"exponential\", fiber = { stiffness = 2e4, stiffening = 3, direction = [0, 1, 0] } "
      "}\n"
      "layers = [{ name = \"fat\", thickness = 0.005, young = 3e3, slide = 0.05, fiber = { stiffness = 0 } "
      "},\n"
      "  { name = \"muscle\", young = 9e3 }]\n");
  const lattice::TissueParams& tissue = scene.params.tissue;
  EXPECT_EQ(tissue.fiber, (lattice::FiberParams{2e4, 3, {0, 1, 0}}));
  EXPECT_EQ(tissue.layers[0].fiber.stiffness, 0);
  EXPECT_EQ(tissue.layers[0].slide, 0.05);
  EXPECT_EQ(tissue.layers[1].fiber, tissue.fiber);
  int rows = 0;
  for (const TissueRow& row : scene.tissues)
    rows += row.component == "layer muscle, fibers" || row.component == "all tissue, fibers" ||
            row.component == "layer fat, sliding";
  EXPECT_EQ(rows, 3);
}

// The permanent set is read; the report states it.
TEST(SceneLayers, ReadsPermanentSet) {
  const LatticeScene scene = layered_scene("permanent_set = { share = 0.3, strain = 0.1, time = 2 }\n");
  EXPECT_EQ(scene.params.tissue.set.share, 0.3);
  EXPECT_EQ(scene.params.tissue.set.strain, 0.1);
  EXPECT_EQ(scene.params.tissue.set.time, 2);
  EXPECT_TRUE(lattice::has_cell_laws(scene.params.tissue));
  bool found = false;
  for (const TissueRow& row : scene.tissues) found |= row.component == "permanent set";
  EXPECT_TRUE(found);
}

// Layers have their own values, those of a preset or of the body; the report lists each with its source.
TEST(SceneLayers, ReadsLayers) {
  const LatticeScene scene = layered_scene(
      "tissue = { law = \"exponential\", stiffening = 4, poisson = 0.4 }\n"
      "layers = [{ name = \"skin\", thickness = 0.002, young = 1e5, stiffening = 20 },\n"
      "  { name = \"muscle\", tissue = \"muscle-thigh\", poisson = 0.45 }]\n");
  const std::vector<lattice::TissueLayer>& layers = scene.params.tissue.layers;
  ASSERT_EQ(layers.size(), 2u);
  EXPECT_EQ(layers[0].thickness, 0.002);
  EXPECT_EQ(layers[0].young, 1e5);
  EXPECT_EQ(layers[0].poisson, 0.4);
  EXPECT_EQ(layers[0].stiffening, 20);
  EXPECT_EQ(layers[1].young, 49750);
  EXPECT_EQ(layers[1].poisson, 0.45);
  EXPECT_EQ(layers[1].stiffening, 4);
  bool found = false;
  for (const TissueRow& row : scene.tissues)
    if (row.component == "layer muscle") {
      found = true;
      EXPECT_EQ(row.law, "exponential");
      EXPECT_NE(row.values.find("preset"), std::string::npos) << row.values;
      EXPECT_NE(row.source.find("muscle-thigh"), std::string::npos) << row.source;
    }
  EXPECT_TRUE(found);
}

// Pairs are given, or those of the preset when the table is empty; without it, nothing relaxes.
TEST(SceneLayers, ReadsViscosity) {
  const Prony pairs = layered_scene("viscosity = { pairs = [[0.4, 0.5], [0.2, 10]] }\n").params.tissue.prony;
  EXPECT_EQ(pair_count(pairs), 2);
  EXPECT_DOUBLE_EQ(pairs.pairs[1].ratio, 0.5);
  EXPECT_EQ(pair_count(layered_scene("tissue = \"fat\"\n").params.tissue.prony), 0);
  EXPECT_EQ(layered_scene("tissue = \"fat\"\nviscosity = {}\n").params.tissue.prony.pairs[0].time, 700);
}

// A wrong combination is refused at its key.
TEST(SceneLayers, RefusesWrongCombinations) {
  const std::string gpu = "[world]\ndevice = \"gpu\"\n";
  const std::pair<std::string, std::string> cases[] = {
      {layered_error("tissue = { stiffening = 3 }\n"), "tissue.stiffening: only law = \"exponential\""},
      {layered_error("tissue = { law = \"ogden\" }\n"), "expected an exponent"},
      {layered_error("tissue = { law = \"exponential\", alpha = 2 }\n"),
       "tissue.alpha: only law = \"ogden\""},
      {layered_error("tissue = { law = \"exponential\", partial_cells = true }\n"), "are whole"},
      {layered_error("layers = 3\n"), "layers: expected an array of tables"},
      {layered_error("layers = [{ name = \"a\", young = 1e3 }, { name = \"b\", young = 1e3 }]\n"),
       "every layer except the last needs a thickness"},
      {layered_error("layers = [{ young = 1e3 }]\n"), "a layer needs a name"},
      {layered_error("layers = [{ name = \"a\" }]\n"), "a layer needs young"},
      {layered_error("layers = [{ name = \"a\", young = 1e3, depth = 2 }]\n"), "depth"},
      {layered_error("tissue = { law = \"springs\" }\nlayers = [{ name = \"a\", young = 1e3 }]\n"),
       "springs have no layers"},
      {layered_error("tissue = { law = \"springs\" }\nviscosity = { pairs = [[0.4, 1]] }\n"),
       "springs do not relax"},
      {layered_error("solver = { sleep_speed = 1e-3 }\nviscosity = { pairs = [[0.4, 1]] }\n"),
       "creeps in its sleep"},
      {layered_error("tissue = { fiber = { stiffness = 1e3 } }\n"), "only law = \"exponential\" has fibers"},
      {layered_error("permanent_set = { share = 1.5 }\n"), "share"},
      {layered_error("tissue = { law = \"springs\" }\npermanent_set = { share = 0.3 }\n"),
       "springs do not set"},
      {layered_error("solver = { sleep_speed = 1e-3 }\npermanent_set = { share = 0.3 }\n"),
       "creeps in its sleep"},
      {layered_error("permanent_set = { share = 0.3 }\n", gpu), "world.device = \"gpu\" steps cells"},
      {layered_error("tissue = { law = \"exponential\" }\n", gpu), "world.device = \"gpu\" steps cells"}};
  for (const auto& [found, expected] : cases)
    EXPECT_NE(found.find(expected), std::string::npos) << "expected \"" << expected << "\" in: " << found;
}

}  // namespace
}  // namespace turgor
