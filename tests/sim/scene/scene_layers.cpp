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

// A layer with a toughness resists needles: layers by depth by their sums of thicknesses, all of them if one
// of them has a toughness, and regions by themselves. The report states it.
TEST(SceneLayers, ReadsToughness) {
  const LatticeScene scene = layered_scene(
      "layers = [{ name = \"skin\", thickness = 0.002, young = 2e4, toughness = 1100 },\n"
      "  { name = \"cyst\", hu = [10, 20], young = 1e3, toughness = 50 }, { name = \"gland\", hu = [30, 40], "
      "young = "
      "1e3 },\n"
      "  { name = \"fat\", thickness = 0.006, young = 3e3 }, { name = \"muscle\", young = 9e3 }]\n");
  ASSERT_EQ(scene.inside.size(), 4u);
  const auto expect = [&](std::size_t n, const char* name, double depth, double toughness,
                          bool is_of_layers) {
    const NeedleLayerScene& layer = scene.inside[n];
    EXPECT_EQ(layer.name, name);
    EXPECT_NEAR(layer.depth, depth, 1e-12) << name;
    EXPECT_EQ(layer.toughness, toughness) << name;
    EXPECT_EQ(layer.is_of_layers, is_of_layers) << name;
    EXPECT_EQ(layer.hu.has_value(), !is_of_layers) << name;
  };
  expect(0, "skin", 0.002, 1100, true);
  expect(1, "cyst", 0, 50, false);
  expect(2, "fat", 0.008, kNeedlesOwn, true);
  expect(3, "muscle", 100, kNeedlesOwn, true);
  int rows = 0;
  for (const TissueRow& row : scene.tissues)
    rows += row.component == "layer skin, toughness" && row.values.find("toughness") != row.values.npos;
  EXPECT_EQ(rows, 1);
  // without any toughness needles see no layers
  EXPECT_TRUE(layered_scene("layers = [{ name = \"all\", young = 3e3 }]\n").inside.empty());
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

// A layer may have a law of its own: it has none of the body's stiffening and fibers, and the report names
// it.
TEST(SceneLayers, ReadsLawsOfLayers) {
  const LatticeScene scene = layered_scene(
      "tissue = { law = \"exponential\", stiffening = 4, fiber = { stiffness = 2e4 } }\n"
      "layers = [{ name = \"fat\", thickness = 0.005, young = 3e3, law = \"solid\" },\n"
      "  { name = \"brain\", label = 3, law = \"ogden\", tissue = \"brain-cortex\" },\n"
      "  { name = \"rest\", young = 9e3, law = \"exponential\" }]\n");
  const lattice::TissueParams& tissue = scene.params.tissue;
  EXPECT_EQ(tissue.layers[0].energy, lattice::SolidEnergy::kNeoHookean);
  EXPECT_EQ(tissue.layers[0].stiffening, 0);
  EXPECT_EQ(tissue.layers[0].fiber.stiffness, 0);
  EXPECT_EQ(tissue.layers[1].energy, lattice::SolidEnergy::kOgden);
  EXPECT_EQ(tissue.layers[1].stiffening, -18.7);
  EXPECT_FALSE(tissue.layers[2].energy.has_value()) << "the law of the body";
  EXPECT_EQ(tissue.layers[2].stiffening, 4);
  for (const TissueRow& row : scene.tissues) {
    if (row.component == "layer fat") {
      EXPECT_EQ(row.law, "solid");
    }
    if (row.component == "layer brain, stiffening") {
      EXPECT_EQ(row.law, "ogden");
    }
  }
  const auto error = [](const std::string& keys) {
    return layered_error("layers = [{ name = \"a\", young = 1e3, " + keys + " }]\n");
  };
  EXPECT_NE(error("law = \"ogden\"").find("expected an exponent"), std::string::npos);
  EXPECT_NE(error("law = \"solid\", stiffening = 2").find("only law = \"exponential\""), std::string::npos);
  EXPECT_NE(error("law = \"springs\"").find("law"), std::string::npos);
}

// Layers by label or CT value are regions; the last layer by depth needs no thickness although regions
// follow.
TEST(SceneLayers, ReadsRegions) {
  const std::vector<lattice::TissueLayer> layers =
      layered_scene(
          "layers = [{ name = \"fat\", thickness = 0.005, young = 3e3 }, { name = \"rest\", young = 9e3 },\n"
          "  { name = \"organ\", label = 3, tissue = \"liver\", viscosity = { pairs = [[0.5, 2]] } },\n"
          "  { name = \"dense\", hu = [150, 300], young = 1e5, viscosity = { ratio = 0 } }]\n")
          .params.tissue.layers;
  ASSERT_EQ(layers.size(), 4u);
  EXPECT_FALSE(lattice::is_region(layers[1]));
  EXPECT_EQ(layers[2].label, 3);
  EXPECT_EQ(layers[2].prony, one_pair(1, 2));
  EXPECT_FALSE(layers[1].prony.has_value());
  EXPECT_EQ(*layers[3].hu, (std::array<double, 2>{150, 300}));
  ASSERT_TRUE(layers[3].prony.has_value());
  EXPECT_EQ(pair_count(*layers[3].prony), 0) << "elastic in a viscous body";
}

// Wrong regions are refused at their key.
TEST(SceneLayers, RefusesWrongRegions) {
  const std::string file = "[body.b]\nmodel = \"lattice\"\nct = \"ct.nii\"\n";
  const auto layer = [](const std::string& keys) {
    return "layers = [{ name = \"a\", young = 1e3, " + keys + " }]\n";
  };
  const std::string two = "layers = [{ name = \"a\", young = 1e3, label = 3 }, { name = \"b\", young = 1e3, ";
  const std::pair<std::string, std::string> cases[] = {
      {test::error_of(file + layer("label = 3")), "needs a segmentation"},
      {layered_error(layer("label = 3, thickness = 0.01")), "one of thickness, label and hu"},
      {layered_error(layer("label = 3, hu = [0, 10]")), "one of thickness, label and hu"},
      {layered_error(layer("label = \"livre\"")), "did you mean liver"},
      {layered_error(layer("label = 70000")), "from 1 to 65535"},
      {layered_error(layer("hu = [30, 10]")), "from < to"},
      {layered_error(two + "label = 3 }]\n"), "layer a has the same label"},
      {layered_error("tissue = { labels = { 3 = 2e3 } }\n" + layer("label = 3")),
       "tissue.labels has a modulus"},
      {layered_error("layers = [{ name = \"a\", young = 1e3, hu = [0, 90] }, { name = \"b\", young = 1e3, "
                     "hu = [50, 120] }]\n"),
       "overlaps that of a"},
      {layered_error(layer("label = 3, viscosity = { pairs = [[1.2, 1]] }")), "pairs"},
      {layered_error("solver = { sleep_speed = 1e-3 }\n" + layer("label = 3, viscosity = { ratio = 1 }")),
       "layers: tissue that relaxes"}};
  for (const auto& [found, expected] : cases)
    EXPECT_NE(found.find(expected), std::string::npos) << "expected \"" << expected << "\" in: " << found;
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
