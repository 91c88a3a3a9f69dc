// Laws of a lattice body that a person changes in a running world, and layers by label in a scene.
#include <map>

#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {
namespace {

const Exec kLawThread(1);

/// The block without its cut. Its left half has label 5; three layers by depth, label and CT value.
std::string laws_text(const std::string& law) {
  return "[world]\nduration = 0.2\nframe_rate = 50\ngravity = [0, 30, -80]\n[body.block]\nmodel = "
         "\"lattice\"\nct = \"block.nii\"\n"
         "labels = \"labels.nii\"\nblock = 2\nfixed = \"bone\"\n" +
         law;
}
constexpr const char* kExponential =
    "tissue = { law = \"exponential\", stiffening = 2, fat = 3e3, labels = { 9 = 1e3 }, "
    "fiber = { stiffness = 100, direction = [1, 0, 0] } }\n"
    "viscosity = { pairs = [[0.3, 0.1], [0.2, 0.4]] }\n"
    "layers = [{ name = \"outer\", thickness = 0.01, young = 4e3 },\n"
    "  { name = \"organ\", label = 5, young = 2e3, stiffening = 5, viscosity = { ratio = 0.5, time = 0.2 } "
    "},\n"
    "  { name = \"inner\", young = 5e3 }]\n";
/// Layers of three laws in a neo-Hookean body.
constexpr const char* kMixed =
    "tissue = { fat = 3e3 }\n"
    "layers = [{ name = \"organ\", label = 5, law = \"ogden\", alpha = -8, young = 2e3 },\n"
    "  { name = \"inner\", law = \"exponential\", stiffening = 3, young = 5e3 }]\n";
/// A neo-Hookean layer beside another in an exponential body.
constexpr const char* kLayered =
    "tissue = { law = \"exponential\", stiffening = 4, fat = 3e3 }\n"
    "layers = [{ name = \"organ\", label = 5, law = \"solid\", young = 2e3 },\n"
    "  { name = \"inner\", young = 5e3 }]\n";
constexpr const char* kOgden = "tissue = { law = \"ogden\", alpha = -8, fat = 3e3 }\n";
/// Cells that the body fills in part.
constexpr const char* kPartial = "tissue = { partial_cells = true, fat = 3e3, labels = { 9 = 1e3 } }\n";

class ChangeLaws : public ::testing::Test {
 protected:
  std::filesystem::path folder = test::fresh_folder();

  void SetUp() override {
    test::write_labeled_block(folder, [](int i, int, int k) { return i >= 17 ? 0 : k < 8 ? 9 : 5; });
  }
  Scene read(const std::string& law, const std::vector<std::string>& overrides = {}) const {
    Result<Scene> scene = parse_scene(laws_text(law), folder / "block.toml", overrides);
    EXPECT_TRUE(scene) << scene.error().message;
    return *scene;
  }
  World loaded(const std::string& law, const std::vector<std::string>& overrides = {}) const {
    return test::block_world(kLawThread, read(law, overrides));
  }
};

struct LawChange {
  const char *law, *key, *value;
};
constexpr LawChange kChanges[] = {
    {kExponential, "tissue.muscle", "3e4"},
    {kExponential, "tissue.poisson", "0.3"},
    {kExponential, "tissue.stiffening", "9"},
    {kExponential, "tissue.labels.9", "4e3"},
    {kExponential, "tissue.fiber.stiffness", "5e3"},
    {kExponential, "tissue.fiber.direction", "[0, 0, 1]"},
    {kExponential, "viscosity.pairs[1]", "[0.4, 0.05]"},
    {kExponential, "permanent_set.share", "0.4"},
    {kExponential, "layers[0].thickness", "0.018"},
    {kExponential, "layers[1].young", "6e3"},
    {kExponential, "layers[1].stiffening", "0.5"},
    {kExponential, "layers[1].viscosity.time", "0.05"},
    {kExponential, "layers[2].slide", "0.2"},
    {kLayered, "layers[0].law", "exponential"},
    {kLayered, "layers[1].law", "solid"},
    {kMixed, "layers[0].alpha", "6"},
    {kMixed, "layers[1].stiffening", "9"},
    {kOgden, "tissue.alpha", "5"},
    {kOgden, "viscosity.ratio", "0.6"},
    {"tissue = { fat = 3e3 }\n", "tissue.fat", "900"},
    {kPartial, "tissue.fat", "900"},
    {kPartial, "tissue.poisson", "0.3"},
    {kPartial, "tissue.labels.9", "4e3"},
    {"tissue = { law = \"springs\", fat = 3e3 }\n", "tissue.volume", "3"},
};

// A world whose law changes before its first frame gives the same bits as one that was loaded with the value.
TEST_F(ChangeLaws, ChangedWorldEqualsLoadedWorld) {
  const auto run = [](World& world) {
    for (int n = 0; n < 2; n++) ASSERT_TRUE(step(kLawThread, world));
  };
  std::map<std::string, World> unchanged;  // by law
  for (const auto& [law, name, value] : kChanges) {
    if (!unchanged.contains(law)) run(unchanged.emplace(law, loaded(law)).first->second);
    const World& plain = unchanged.at(law);
    const std::string key = std::string("body.block.") + name;
    auto scene = std::make_shared<const Scene>(read(law));
    World changed = loaded(law), other = loaded(law, {key + "=" + value});
    const Status applied = apply_request(kLawThread, ChangeRequest{key, value}, scene, changed);
    ASSERT_TRUE(applied) << applied.error().message;
    run(changed), run(other);
    EXPECT_EQ(state_hash(changed), state_hash(other)) << key;
    EXPECT_NE(state_hash(changed), state_hash(plain)) << key;
    // and back
    ASSERT_TRUE(apply_request(kLawThread, ChangeRequest{key, std::nullopt}, scene, changed));
    EXPECT_EQ(changed.lattice_bodies[0].model.params.tissue, plain.lattice_bodies[0].model.params.tissue);
    EXPECT_EQ(changed.lattice_bodies[0].model.anatomy.cell_young,
              plain.lattice_bodies[0].model.anatomy.cell_young)
        << key;
  }
}

// Every key of kChanges is listed with a range, and acts at once.
TEST_F(ChangeLaws, KeysAreListedAsLive) {
  for (const auto& [law, name, value] : kChanges) {
    const Scene scene = read(law);
    const std::string path = std::string("body.block.") + name;
    bool found = false;
    for (const SceneKey& key : scene_keys(scene.text, scene.file)) {
      if (key.path != path) continue;
      found = true;
      EXPECT_EQ(why_not_live(scene, key), "") << path;
      EXPECT_LT(key.allowed.low, key.allowed.high) << path;
    }
    EXPECT_TRUE(found) << path;
  }
}

// Keys of another law, and bodies that keep no moduli, say why they wait.
TEST_F(ChangeLaws, KeysThatWaitSayWhy) {
  const auto waits = [&](const std::string& law, const std::string& name) {
    const Scene scene = read(law);
    for (const SceneKey& key : scene_keys(scene.text, scene.file))
      if (key.path == "body.block." + name) return why_not_live(scene, key);
    return std::string("no such key");
  };
  EXPECT_EQ(waits(kOgden, "tissue.stiffening"), "the tissue has another law");
  EXPECT_EQ(waits(kExponential, "tissue.alpha"), "the tissue has another law");
  EXPECT_EQ(waits(kExponential, "tissue.volume"), "the tissue has another law");
  EXPECT_EQ(waits(kOgden, "layers.young"), "the body has no layers");
  EXPECT_EQ(waits(kMixed, "layers[0].stiffening"), "the tissue has another law");
  EXPECT_EQ(waits(kMixed, "layers[1].alpha"), "the tissue has another law");
  EXPECT_EQ(waits(kMixed, "tissue.stiffening"), "the tissue has another law");
  EXPECT_EQ(waits(kExponential, "layers[1].label"), "the regions of the lattice depend on it");
  EXPECT_EQ(waits(kExponential, "layers[1].toughness"), "needles read it when they begin");
  EXPECT_EQ(waits(kExponential, "tissue.fiber.direction_field"), "the elements of the lattice depend on it");
  EXPECT_EQ(waits(kExponential, "tissue.fat_max"), "the elements of the lattice depend on it");
  EXPECT_EQ(waits("tissue = { law = \"springs\" }\n", "viscosity.ratio"), "the tissue has another law");
  EXPECT_EQ(waits(kPartial, "viscosity.ratio"), "partial cells do not relax (tissue.partial_cells = false)");
  EXPECT_EQ(waits(kPartial, "permanent_set.share"),
            "partial cells do not relax (tissue.partial_cells = false)");
  EXPECT_EQ(waits("solver = { method = \"pbd\" }\nskin = { law = \"area\" }\n", "tissue.fat"),
            "projections have no moduli");
}

// A change that waits for a restart does not reach the running body together with one that acts at once.
TEST_F(ChangeLaws, WaitingChangesStayOut) {
  auto scene = std::make_shared<const Scene>(read(kExponential));
  World world = loaded(kExponential);
  ASSERT_TRUE(apply_request(kLawThread, ChangeRequest{"body.block.tissue.fat_max", "20"}, scene, world));
  ASSERT_TRUE(apply_request(kLawThread, ChangeRequest{"body.block.tissue.fat", "700"}, scene, world));
  EXPECT_EQ(world.lattice_bodies[0].model.params.tissue.fat_max, -30);
  EXPECT_EQ(world.lattice_bodies[0].model.params.tissue.fat, 700);
}

// A region without any voxel is noted, since its law has no effect.
TEST_F(ChangeLaws, EmptyRegionsAreNoted) {
  const World world = loaded(
      "layers = [{ name = \"organ\", label = 5, young = 2e3 }, { name = \"cyst\", label = 77, young = 1e3 "
      "},\n"
      "  { name = \"dense\", hu = [300, 400], young = 9e4 }]\n");
  const std::vector<std::string>& notes = world.lattice_bodies[0].notes;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0], "layer cyst is empty: no voxel has the label 77");
  EXPECT_EQ(notes[1], "layer dense is empty: no voxel has a CT value from 300 to 400 HU");
}

// The report names the law of every layer: its values, its region and its relaxation.
TEST_F(ChangeLaws, ReportNamesLayersByLabel) {
  const Scene scene = read(kExponential);
  const auto has_row = [&](const std::string& component, const std::string& values) {
    for (const TissueRow& row : scene.lattice_bodies[0].tissues)
      if (row.component == component && row.values.find(values) != row.values.npos) return true;
    return false;
  };
  EXPECT_TRUE(has_row("layer organ", "young 2 kPa"));
  EXPECT_TRUE(has_row("layer organ, stiffening", "stiffening 5"));
  EXPECT_TRUE(has_row("layer organ, region", "label 5"));
  EXPECT_TRUE(has_row("layer organ, viscosity", "tau1 0.2 s"));
  EXPECT_TRUE(has_row("layer outer, thickness", "thickness"));
}

}  // namespace
}  // namespace turgor
