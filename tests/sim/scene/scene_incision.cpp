// Undermining of cuts in scenes.
#include "turgor/sim/scene/scene_incision.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

constexpr const char* kCutLeg =
    "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n"
    "[incision.c]\nbody = \"b\"\nfrom_fraction = [0.4, 0, 0.5]\nto_fraction = [0.6, 0, 0.5]\ndepth = 0.01\n";

// The width and the depth of an undermined surface are read; without a depth it is half that of the cut.
TEST(SceneIncision, ReadsUndermining) {
  const auto read = [](const char* keys) {
    return parse_scene(std::string(kCutLeg) + keys, "s.toml")->incisions[0].blade.undermine;
  };
  EXPECT_EQ(read("").width, 0);
  EXPECT_EQ(read("undermine = { width = 0.02 }\n").depth, 0.005);
  const lattice::Undermining both = read("undermine = { width = 0.03, depth = 0.008 }\n");
  EXPECT_EQ(both.width, 0.03);
  EXPECT_EQ(both.depth, 0.008);
}

// So is one around an excision, whose floor it may reach but not pass.
TEST(SceneIncision, ReadsUnderminingOfExcision) {
  const auto text = [](const char* depth) {
    return std::string(
               "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\nsolver = { method = \"vbd\" }\n"
               "[excision.c]\nbody = \"b\"\ncenter_fraction = [0.5, 0, 0.5]\nlength = 0.04\nwidth = 0.01\n"
               "depth = 0.01\nundermine = { width = 0.02, depth = ") +
           depth + " }\n";
  };
  const Result<Scene> scene = parse_scene(text("0.01"), "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->incisions[0].blade.undermine.width, 0.02);
  EXPECT_EQ(scene->incisions[0].blade.undermine.depth, 0.01);
  EXPECT_NE(test::error_of(text("0.012")).find("at most the depth of the cut"), std::string::npos);
}

// A surface below the cut, and one under a removed region, are errors.
TEST(SceneIncision, RefusesUnderminingBelowTheCut) {
  const auto error = [](const char* keys) { return test::error_of(std::string(kCutLeg) + keys); };
  EXPECT_NE(error("undermine = { width = 0.02, depth = 0.02 }\n").find("at most the depth of the cut"),
            std::string::npos);
  EXPECT_NE(error("undermine = { width = 0.02 }\nwidth = 0.01\n").find("no lips to undermine"),
            std::string::npos);
}

// Two ends in millimeters are two problems; that nothing of the cut was read is no third one.
TEST(SceneIncision, WrongEndsAreNamedOnce) {
  EXPECT_EQ(
      test::error_of("[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n"
                     "[incision.c]\nbody = \"b\"\nfrom = [20, -110, 50]\nto = [20, -110, -50]\n"),
      "s.toml:6:13: incision.c.from: expected numbers from -100 to 100 [m], found -110 m; -110 mm are -0.11\n"
      "s.toml:7:11: incision.c.to: expected numbers from -100 to 100 [m], found -110 m; -110 mm are -0.11");
}

}  // namespace
}  // namespace turgor
