#include "turgor/sim/report/missed_body.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/block_scene.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

using namespace test;

constexpr const char* kPad =
    "[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }\n"
    "fixed = \"bottom\"\ncache = false\n";

/// Warnings after a third of a second with such a tool.
std::vector<std::string> warnings_of(const std::string& body, const std::string& motion) {
  const Result<Scene> scene = parse_scene(
      body + "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n" + motion + "\n", "s.toml");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  World world = sfem_world(Exec(1), *scene);
  for (int frame = 0; frame < 20; frame++) EXPECT_TRUE(step(Exec(1), world));
  return touch_warnings(world);
}

// A tool without contact causes a warning with its least distance and the body's bounds.
TEST(MissedBody, ToolWithoutContactIsReported) {
  const std::vector<std::string> warnings =
      warnings_of(kPad, "path = [[0, 0.03, 0.03, 0.2], [0.1, 0.03, 0.03, 0.05], [0.3, 0.03, 0.03, 0.2]]");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "finger: it never touched pad; the body is between (0, 0, 0) m and (0.06, 0.06, 0.03) m; its "
            "nearest point, (0.03, 0.03, 0.03) m, is 0.014 m away (at 0.100 s)");
}

// The distance is that of the tool where it was, and not that of a path which it did not follow.
TEST(MissedBody, DistanceIsOfToolAndNotOfPath) {
  const Result<Scene> scene = parse_scene(std::string(kPad) +
                                              "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n"
                                              "path = [[0, 0.03, 0.03, 0.2]]\n",
                                          "s.toml");
  ASSERT_TRUE(scene);
  World world = sfem_world(Exec(1), *scene);
  for (int frame = 0; frame < 20; frame++) ASSERT_TRUE(step(Exec(1), world));
  world.tools[0].path.rows.front().position.z = 0.03;  // on the pad
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("is 0.164 m away"), std::string::npos) << warnings[0];
}

// Every model reports a tool without contact.
TEST(MissedBody, EveryModelReportsMissingContact) {
  const std::string away = "path = [[0, 2, 0, 0]]";
  const std::filesystem::path ct = fresh_folder() / "block.nii";
  ASSERT_TRUE(write_ct(ct, block_ct()));
  for (const std::string& body :
       {std::string("[body.pad]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\", detail = 0.3 }\n"),
        "[body.pad]\nmodel = \"lattice\"\nct = \"" + ct.string() + "\"\nblock = 2\nfixed = \"bone\"\n"}) {
    const std::vector<std::string> warnings = warnings_of(body, away);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with("finger: it never touched pad; the body is between ("))
        << warnings[0];
  }
}

// A tool with contact causes no warning.
TEST(MissedBody, TouchingTool_NoWarning) {
  EXPECT_TRUE(
      warnings_of(kPad, "press = { at_fraction = [0.5, 0.5, 1], start = 0, duration = 0.1 }").empty());
}

// A press point farther from the surface than the tool's width causes a warning.
TEST(MissedBody, DistantPressPointIsReported) {
  const auto press = [](const std::string& keys) {
    return warnings_of(kPad, "press = { " + keys + ", start = 0, duration = 0.1, slide = 0.05 }");
  };
  const std::vector<std::string> warnings = press("at = [0.03, 0.03, 0.5], to = [0.04, 0.03, -0.2]");
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(
      warnings[0],
      "finger: press.at = (0.03, 0.03, 0.5) m is not on pad and was moved to its nearest point; the body is "
      "between (0, 0, 0) m and (0.06, 0.06, 0.03) m; its nearest point, (0.03, 0.03, 0.03) m, is 0.47 m "
      "away");
  EXPECT_TRUE(warnings[1].starts_with("finger: press.to = (0.04, 0.03, -0.2) m is not on pad"))
      << warnings[1];
  EXPECT_TRUE(press("at = [0.03, 0.03, 0.04], to = [0.04, 0.03, 0.04]").empty())
      << "nearer than the tool's width";
  const std::vector<std::string> grasp =
      warnings_of(kPad, "grasp = { at = [0.03, 0.03, 0.1], start = 0, duration = 0.1 }");
  ASSERT_EQ(grasp.size(), 1u);
  EXPECT_TRUE(grasp[0].starts_with("finger: grasp.at = (0.03, 0.03, 0.1) m is not on pad")) << grasp[0];
}

}  // namespace
}  // namespace turgor
