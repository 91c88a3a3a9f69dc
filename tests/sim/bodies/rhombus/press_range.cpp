// The range of depths and tips for which rhombus chains are valid, in scenes.
#include <string>

#include <gtest/gtest.h>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

/// A phantom liver of porcine tissue after a press by a ball from the front.
World pressed(const std::string& radius, const std::string& depth) {
  const Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.2\n[body.liver]\nmodel = \"rhombus\"\n"
      "surface = { phantom = \"liver\", detail = 0.3 }\ntissue = \"liver-porcine\"\n[tool.finger]\n"
      "body = \"liver\"\nshape = { sphere = " +
          radius + " }\npress = { at_fraction = [0.5, 0, 0.5], depth = " + depth +
          ", start = 0, duration = 0.1, hold = 1 }\n",
      "s.toml");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  World world = test::sfem_world(Exec(1), *scene);
  for (int frame = 0; frame < 12; frame++) EXPECT_TRUE(step(Exec(1), world));
  return world;
}

// A tip of 0.3 mm pressed by 1 mm has Sneddon's force, and so has one pressed by five radii.
TEST(RhombusPressRange, SharpAndDeepPressesMatchSneddon) {
  for (const auto& [radius, depth] : {std::pair{"0.0003", "0.001"}, {"0.0017", "0.0085"}}) {
    const World world = pressed(radius, depth);
    const double expected =
        rhombus::sneddon_force(rhombus::contact_modulus(12.5e3, 0.5), std::stod(radius), std::stod(depth));
    EXPECT_NEAR(norm(world.tools[0].samples.back().force) / expected, 1, 0.05) << radius;
    EXPECT_TRUE(touch_warnings(world).empty()) << radius;
    EXPECT_TRUE(notes_of(world).empty()) << radius;
  }
}

// A press beyond six radii causes a warning with its duration.
TEST(RhombusPressRange, DeeperPressIsReported) {
  const World world = pressed("0.0017", "0.011");
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("finger: for ")) << warnings[0];
  EXPECT_NE(warnings[0].find("pressed deeper than 6 radii of its tip"), std::string::npos) << warnings[0];
}

// A tip that is sharper than the model's sharpest one causes a note.
TEST(RhombusPressRange, SharperTipIsReported) {
  const std::vector<std::string> notes = notes_of(pressed("0.00004", "0.0001"));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(notes[0].starts_with("liver: finger: its tip of 0.04 mm acts as one of 0.1 mm")) << notes[0];
}

}  // namespace
}  // namespace turgor
