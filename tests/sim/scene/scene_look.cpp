#include "turgor/sim/scene/scene_look.hpp"

#include <gtest/gtest.h>

#include "tests/refused.hpp"

namespace turgor {
namespace {

Result<Scene> read(const std::string& liver, const std::string& output) {
  return parse_scene(
      "[body.liver]\nmodel = \"sfem\"\nsurface = \"liver.obj\"\nyoung = 4e3\n"
      "fixed = { sides = \"back\", depth = 0.3 }\n" +
          liver + "\n[output]\n" + output + "\n",
      "scene.toml");
}

// Without keys nothing is cut away, and the kind of body decides what is wet.
TEST(SceneLook, DefaultsAreAutomatic) {
  const Result<Scene> scene = read("", "");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_FALSE(scene->look.cutaway);
  EXPECT_TRUE(scene->look.wet.empty());
}

// All keys are read.
TEST(SceneLook, KeysAreRead) {
  const Result<Scene> scene = read("wet = false",
                                   "cutaway = { body = \"liver\", at = [0.1, 0.2, 0.3], normal = [1, 0, 0], "
                                   "wedge = [0, 0, 2], inclusions = \"cut\" }");
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->look.cutaway);
  EXPECT_EQ(scene->look.cutaway->body, (BodyId{BodyKind::kSfem, 0}));
  EXPECT_FALSE(scene->look.cutaway->by_fraction);
  EXPECT_EQ(scene->look.cutaway->at, (Vec3d{0.1, 0.2, 0.3}));
  EXPECT_EQ(scene->look.cutaway->normal, (Vec3d{1, 0, 0}));
  EXPECT_EQ(scene->look.cutaway->wedge, (Vec3d{0, 0, 2}));
  EXPECT_TRUE(scene->look.cutaway->cuts_inclusions);
  EXPECT_FALSE(scene->look.wet.at("liver"));
}

// Planes without a direction, parallel planes, two points and unknown bodies are refused.
TEST(SceneLook, MistakesAreRefused) {
  EXPECT_REFUSED(read("", "cutaway = { normal = [1, 0, 0] }"), "output.cutaway", "the body that is cut away");
  EXPECT_REFUSED(read("", "cutaway = { body = \"livr\" }"), "livr", "liver");
  EXPECT_REFUSED(read("", "cutaway = { body = \"liver\", normal = [0, 0, 0] }"), "without length");
  EXPECT_REFUSED(read("", "cutaway = { body = \"liver\", wedge = [0, 2, 0] }"), "not parallel");
  EXPECT_REFUSED(read("", "cutaway = { body = \"liver\", at = [0, 0, 0], at_fraction = [0, 0, 0] }"),
                 "found both");
}

}  // namespace
}  // namespace turgor
