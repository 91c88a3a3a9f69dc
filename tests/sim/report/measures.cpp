#include "turgor/sim/report/measures.hpp"

#include <cmath>

#include "sim/block_scene.hpp"

namespace turgor {
namespace {

/// The pull at the block's cut, which runs along z, with Langer's lines in the given direction.
SkinPull pull_with(const std::string& direction, const std::string& law = "\"fibre\"") {
  const Exec exec(1);
  const Scene scene = test::block_scene(
      test::fresh_folder(),
      {"body.block.skin={ law = " + law + ", tension = [60, 30], direction = " + direction + " }"});
  const World world = test::block_world(exec, scene);
  const LatticeBody& body = world.lattices[0];
  return skin_pull(body.model, lattice::lay_blade(body.model, body.state, world.cuts[0].blade).value());
}

TEST(Measures, ACutAlongTheLinesIsPulledOpenByTheTensionAcrossThem) {
  const SkinPull along = pull_with("[0, 0, 1]");
  EXPECT_NEAR(along.angle, 0, 0.1);
  EXPECT_NEAR(along.opening, 30, 0.1);
  EXPECT_NEAR(along.lengthwise, 60, 0.1);
  const SkinPull across = pull_with("[1, 0, 0]");
  EXPECT_NEAR(across.angle, 90, 0.1);
  EXPECT_NEAR(across.opening, 60, 0.1);
  const SkinPull oblique = pull_with("[1, 0, 1]");
  EXPECT_NEAR(oblique.angle, 45, 0.1);
  EXPECT_NEAR(oblique.opening, 45, 0.1);
}

TEST(Measures, TheAreaLawPullsAlikeInAllDirections) {
  EXPECT_NEAR(pull_with("[1, 0, 0]", "\"area\"").opening, 45, 1e-9);
}

TEST(Measures, SeriesStartWithTheBladeAndSolverSamplesAreSnapshots) {
  const Exec exec(1);
  World world = test::block_world(exec, test::block_scene(test::fresh_folder()));
  Measures measures = make_measures(world);
  for (int frame = 1; frame <= 10; frame++)
    measure_frame(exec, world, step(exec, world, frame % 5 == 0).value(), frame % 5 == 0, measures);
  EXPECT_EQ(measures.frame_seconds.size(), 10u);
  ASSERT_EQ(measures.cuts.size(), 1u);
  EXPECT_EQ(measures.cuts[0].series.size(), 8u);
  EXPECT_NEAR(measures.cuts[0].series.front().time, 0.06, 1e-9);
  EXPECT_GT(measures.cuts[0].series.back().gape_max, measures.cuts[0].series.front().gape_max);
  ASSERT_EQ(measures.solver.size(), 2u);
  EXPECT_GT(measures.solver[0].residual.largest, 0);
  EXPECT_TRUE(std::isfinite(measures.solver[1].energy));
}

}  // namespace
}  // namespace turgor
