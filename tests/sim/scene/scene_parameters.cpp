#include "turgor/sim/scene/scene_parameters.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// A parameter of a scene; empty if it is not listed.
SceneParameter parameter_of(const Scene& scene, const std::string& key) {
  for (const SceneParameter& p : scene.parameters)
    if (p.key == key) return p;
  return {};
}

// Every parameter has its value, unit and source: a line of the scene, an override, or the default.
TEST(SceneParameters, HaveValueUnitAndSource) {
  const Result<Scene> scene = parse_scene(
      "[body.torso]\nmodel = \"lattice\"\nct = \"ct.nii\"\nskin = { tension = [60, 30] }\n"
      "[incision.cut]\nbody = \"torso\"\nfrom = [0, 0, 0]\nto = [0, 0, 0.1]\ndepth = 0.01\n",
      "scene.toml", {"body.torso.tissue.fat=4000"});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneParameter tension = parameter_of(*scene, "body.torso.skin.tension"),
                       fat = parameter_of(*scene, "body.torso.tissue.fat"),
                       muscle = parameter_of(*scene, "body.torso.tissue.muscle"),
                       depth = parameter_of(*scene, "incision.cut.depth");
  EXPECT_EQ(tension.value, "[60, 30]");
  EXPECT_EQ(tension.unit, "N/m");
  EXPECT_EQ(tension.source, "scene, line 4");
  EXPECT_EQ(fat.value, "4000");
  EXPECT_EQ(fat.source, "--set body.torso.tissue.fat");
  EXPECT_EQ(muscle.value, "20000");
  EXPECT_EQ(muscle.unit, "Pa");
  EXPECT_EQ(muscle.source, "default");
  EXPECT_EQ(depth.value, "0.01");
  EXPECT_EQ(parameter_of(*scene, "incision.cut.to").value, "[0, 0, 0.1]");
  EXPECT_EQ(depth.unit, "m");
}

// Keys of the output are no parameters.
TEST(SceneParameters, OmitOutput) {
  const Result<Scene> scene =
      parse_scene("[body.torso]\nmodel = \"lattice\"\nct = \"ct.nii\"\n[output]\nsnapshots = { every = 1 }\n",
                  "scene.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  for (const SceneParameter& p : scene->parameters) EXPECT_FALSE(p.key.starts_with("output")) << p.key;
}

}  // namespace
}  // namespace turgor
