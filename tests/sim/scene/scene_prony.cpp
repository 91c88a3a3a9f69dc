#include "turgor/sim/scene/scene_prony.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

using test::error_of;

constexpr const char* kSfem = "[body.b]\nmodel = \"sfem\"\nblock = { size = [1, 1, 1], count = [2, 2, 2] }\n";
constexpr const char* kRhombus = "[body.b]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\n";

// Three pairs of shares become ratios to the long-term stress, in both models.
TEST(SceneProny, PairsReachBodies) {
  const std::string pairs = "viscosity.pairs = [[0.4, 0.5], [0.2, 10], [0.15, 200]]\n";
  const Prony sfem = parse_scene(kSfem + pairs, "s.toml")->sfem_bodies[0].viscosity;
  const Prony rhombus = parse_scene(kRhombus + pairs, "s.toml")->rhombus_bodies[0].params.viscosity;
  ASSERT_EQ(pair_count(sfem), 3);
  EXPECT_NEAR(sfem.pairs[0].ratio, 0.4 / 0.25, 1e-12);
  EXPECT_NEAR(sfem.pairs[2].ratio, 0.15 / 0.25, 1e-12);
  EXPECT_EQ(sfem.pairs[1].time, 10);
  EXPECT_NEAR(1 / (1 + total_ratio(sfem)), 0.25, 1e-12) << "the static share of the stress";
  EXPECT_EQ(sfem, rhombus);
}

// Pairs replace those of a preset, and the report has a row of each.
TEST(SceneProny, PairsWinOverPreset) {
  const SfemScene fat =
      parse_scene(kSfem + std::string("tissue = \"fat\"\nviscosity.pairs = [[0.5, 2]]\n"), "s.toml")
          ->sfem_bodies[0];
  EXPECT_EQ(pair_count(fat.viscosity), 1);
  EXPECT_NEAR(fat.viscosity.pairs[0].ratio, 1, 1e-12);
  EXPECT_EQ(fat.tissues.back().values, "g1 0.5, scene; tau1 2 s, scene");
}

// Wrong pairs are errors that state the expected form.
TEST(SceneProny, RejectsWrongPairs) {
  for (const char* pairs : {"1", "[]", "[[0.5]]", "[[1, 2]]", "[[0.2, 1], [0.2, 1], [0.2, 1], [0.2, 1]]",
                            "[[0.2, 1, 3]]", "[[-0.1, 1]]", "[[0.5, 0]]"})
    EXPECT_NE(
        error_of(kSfem + std::string("viscosity.pairs = ") + pairs + "\n").find("body.b.viscosity.pairs"),
        std::string::npos)
        << pairs;
  EXPECT_NE(error_of(kSfem + std::string("viscosity.pairs = [[0.5, 1], [0.5, 2]]\n")).find("below 0.999"),
            std::string::npos);
  EXPECT_NE(error_of(kSfem + std::string("viscosity = { ratio = 1, pairs = [[0.5, 1]] }\n"))
                .find("either one pair, ratio and time, or pairs"),
            std::string::npos);
}

}  // namespace
}  // namespace turgor
