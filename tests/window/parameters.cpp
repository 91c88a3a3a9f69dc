#include "turgor/window/parameters.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr const char* kText = R"([world]
gravity = [0, 0, -9.81]
[body.torso]
model = "lattice"
ct = { phantom = "torso" }
skin = { tension = 60 }
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [1, 0, 0], up = [0, 0, 1], columns = 4, rows = 4 }
)";

Scene scene(const std::vector<std::string>& overrides = {}) {
  Result<Scene> read = parse_scene(kText, "a.toml", overrides);
  EXPECT_TRUE(read) << read.error().message;
  return *read;
}

const Parameter& find(const ParameterList& list, const std::string& path) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Parameter& p) { return p.key.path == path; });
  EXPECT_NE(found, list.end()) << path;
  return *found;
}

// The list of parameters has units, limits and current values.
TEST(Parameters, ListHasUnitsLimitsAndValues) {
  const ParameterList list = list_parameters(scene());
  const Parameter& tension = find(list, "body.torso.skin.tension");
  EXPECT_EQ(tension.value[0], 60) << "the value of the file";
  EXPECT_EQ(tension.key.unit, "N/m");
  EXPECT_EQ(tension.key.allowed.low, 0);
  EXPECT_TRUE(tension.waits.empty());
  EXPECT_EQ(find(list, "body.torso.skin.stiffness").value[0], 300) << "the default value";
  const Parameter& gravity = find(list, "world.gravity");
  EXPECT_EQ(gravity.count, 3);
  EXPECT_EQ(gravity.value[2], -9.81);
  const ParameterList changed = list_parameters(scene({"body.torso.skin.tension=75"}));
  EXPECT_EQ(find(changed, "body.torso.skin.tension").value[0], 75) << "the changed value";
}

// Parameters that take effect at once come first; the others state why they do not.
TEST(Parameters, LiveParametersComeFirst) {
  const ParameterList list = list_parameters(scene());
  EXPECT_TRUE(
      std::is_partitioned(list.begin(), list.end(), [](const Parameter& p) { return p.waits.empty(); }));
  EXPECT_TRUE(find(list, "body.torso.tissue.fat").waits.empty());
  EXPECT_EQ(find(list, "body.torso.tissue.fat_max").waits, "the elements of the lattice depend on it");
  EXPECT_EQ(find(list, "body.torso.tissue.stiffening").waits, "the tissue has another law");
  EXPECT_TRUE(find(list, "body.flag.wind.velocity").waits.empty());
  EXPECT_EQ(find(list, "body.torso.skin.stiffening").waits, "the skin has another law");
  EXPECT_TRUE(find(list, "body.torso.skin.stiffness").waits.empty());
}

// Modulus and friction take effect at once if the model allows it.
TEST(Parameters, ModulusAndFrictionDependOnModel) {
  const auto waits = [](const std::string& inclusion, const std::string& path) {
    const std::string text =
        "[world]\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [1, 1, 1], count = [2, 2, 2] }\n" +
        inclusion +
        "[body.chain]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\n"
        "[tool.a]\nbody = \"pad\"\nshape = { sphere = 0.01 }\npath = [[0, 0, 0, 2]]\n"
        "[tool.b]\nbody = \"chain\"\nshape = { sphere = 0.01 }\npath = [[0, 0, 0, 2]]\n";
    const Result<Scene> scene = parse_scene(text, "b.toml");
    EXPECT_TRUE(scene) << scene.error().message;
    return find(list_parameters(*scene), path).waits;
  };
  EXPECT_EQ(waits("", "body.pad.young"), "");
  EXPECT_EQ(waits("", "tool.a.friction"), "");
  EXPECT_EQ(waits("", "tool.b.friction"), "chains have no friction");
  EXPECT_NE(waits("inclusion.stone = { center = [0.5, 0.5, 0.5], young = 1e5 }\n", "body.pad.young"), "");
  EXPECT_NE(waits("", "body.pad.poisson"), "");
  EXPECT_NE(waits("", "world.frame_rate"), "");
}

// A value that is changed in the window is accepted by the scene.
TEST(Parameters, ChangedValueIsAcceptedByScene) {
  for (Parameter parameter : list_parameters(scene())) {
    for (double& value : parameter.value) value = limited(parameter.key.allowed, value * 1.03);
    const Result<Scene> taken =
        parse_scene(kText, "a.toml", {parameter.key.path + "=" + value_text(parameter)});
    EXPECT_TRUE(taken || !parameter.waits.empty()) << parameter.key.path;
  }
}

// Layers, Prony pairs and a tension in two directions are offered with their ranges; a changed value is
// accepted.
TEST(Parameters, LayersAndPairsAreOffered) {
  const std::string text =
      "[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\nskin = { tension = [60, 30] }\n"
      "tissue = { law = \"exponential\", stiffening = 2 }\nviscosity = { pairs = [[0.4, 0.5], [0.2, 9]] }\n"
      "layers = [{ name = \"fat\", thickness = 0.01, young = 4e3 },\n"
      "  { name = \"organ\", label = 3, young = 2e3, stiffening = 5, slide = 0.5 }]\n";
  const Result<Scene> layered = parse_scene(text, "a.toml");
  ASSERT_TRUE(layered) << layered.error().message;
  const ParameterList list = list_parameters(*layered);
  for (const char* key : {"skin.tension", "viscosity.pairs[1]", "layers[0].thickness", "layers[1].stiffening",
                          "layers[1].slide", "tissue.stiffening"}) {
    Parameter parameter = find(list, std::string("body.torso.") + key);
    EXPECT_EQ(parameter.waits, "") << key;
    for (double& value : parameter.value) value *= 0.97;
    const Result<Scene> taken =
        parse_scene(text, "a.toml", {parameter.key.path + "=" + value_text(parameter)});
    EXPECT_TRUE(taken) << key;
  }
  EXPECT_EQ(value_text(find(list, "body.torso.viscosity.pairs[1]")), "[0.2, 9]");
  EXPECT_FALSE(find(list, "body.torso.layers[1].label").waits.empty());
}

// Every parameter has a range, and a value that differs from the opened one can be reset.
TEST(Parameters, RangeOwnerAndReset) {
  const std::vector<std::string> opened = {"body.torso.skin.tension=75"};
  const ParameterList list = list_parameters(scene({"body.torso.skin.tension=80"}), opened);
  const Parameter& tension = find(list, "body.torso.skin.tension");
  EXPECT_TRUE(tension.is_changed);
  EXPECT_EQ(tension.opened, "75");
  EXPECT_EQ(owner_of(tension), "body.torso");
  EXPECT_EQ(unit_and_range(tension), "N/m, 0 or more");
  const Parameter& fat = find(list, "body.torso.tissue.fat");
  EXPECT_FALSE(fat.is_changed);
  EXPECT_EQ(unit_and_range(fat), "Pa, 0.001 or more");
  EXPECT_EQ(owner_of(find(list, "world.gravity")), "world");
  EXPECT_EQ(unit_and_range(find(list, "body.torso.stiffness_scale")), "from 0.01 to 100");
  for (const Parameter& one : list) EXPECT_FALSE(unit_and_range(one).empty()) << one.key.path;
}

// Values are clamped to their limits and kept away from rejected ones.
TEST(Parameters, ValuesAreClampedToLimits) {
  EXPECT_EQ(limited(within(0, 10), 12), 10);
  EXPECT_EQ(limited(not_negative(""), -3), 0);
  EXPECT_GT(limited(positive(""), -3), 0);
}

}  // namespace
}  // namespace turgor
