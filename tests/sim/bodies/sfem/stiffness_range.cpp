// Forces over the whole range of Young's moduli that a scene may have.
#include <filesystem>

#include <gtest/gtest.h>

#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

double force_with(const char* young) {
  const std::string text =
      std::string(
          "[body.pad]\nmodel = \"sfem\"\ncache = false\n"
          "block = { size = [0.04, 0.04, 0.02], count = [4, 4, 2] }\nyoung = ") +
      young +
      "\n[tool.ball]\nbody = \"pad\"\nshape = { sphere = 0.008 }\nfriction = 0.3\n"
      "press = { at_fraction = [0.5, 0.5, 1], depth = 0.002, start = 0, duration = 0.05 }\n";
  const Result<Scene> scene = parse_scene(text, std::filesystem::path("s.toml"));
  EXPECT_TRUE(scene) << scene.error().message;
  if (!scene) return 0;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  for (int frame = 0; frame < 3; frame++) EXPECT_TRUE(step(Exec(2), *world));
  return norm(world->tools[0].samples.back().force);
}

// Forces are proportional to the modulus from the lower to the upper limit of its range.
TEST(StiffnessRange, ForcesScaleWithModulus) {
  const double usual = force_with("4e3") / 4e3;
  EXPECT_GT(usual, 0);
  EXPECT_NEAR(force_with("1e-3") / 1e-3 / usual, 1, 1e-3);
  EXPECT_NEAR(force_with("1e12") / 1e12 / usual, 1, 1e-3);
}

}  // namespace
}  // namespace turgor
