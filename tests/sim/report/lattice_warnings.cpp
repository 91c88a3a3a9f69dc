#include "turgor/sim/report/lattice_warnings.hpp"

#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"

namespace turgor {
namespace {

const Exec kExec(2);

std::vector<std::string> warnings_with(const std::vector<std::string>& overrides) {
  const Scene scene = test::block_scene(test::fresh_folder(), overrides);
  World world = test::block_world(kExec, scene);
  for (int n = 0; n < 6; n++) EXPECT_TRUE(step(kExec, world));
  return lattice_warnings(kExec, world);
}

// A cut from the skin into thick tissue causes no warning.
TEST(LatticeWarnings, CutIntoThickTissue_NoWarning) {
  const std::vector<std::string> warnings = warnings_with({});
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

// A blade off the skin causes a warning with its distance and its new position.
TEST(LatticeWarnings, BladeInAirIsMovedToSkin) {
  const std::vector<std::string> warnings =
      warnings_with({"incision.cut.from=[0.002, -0.05, -0.03]", "incision.cut.to=[0.002, -0.05, 0.03]"});
  ASSERT_EQ(warnings.size(), 1u) << "one warning per blade";
  EXPECT_TRUE(warnings[0].starts_with(
      "incision 'cut': its ends, (0.002, -0.05, -0.03) m and (0.002, -0.05, 0.03) m, are 36 and 36 mm off "
      "the "
      "skin: the blade was moved to the skin between (0.002, -0.014, -0.03) m and (0.002, -0.014, 0.03) m"))
      << warnings[0];
  EXPECT_EQ(warnings[0].find("e-"), std::string::npos)
      << "values near zero are printed as 0: " << warnings[0];
}

// A cut nearly through the body causes a warning with the number of cells below it.
TEST(LatticeWarnings, DeepCutReportsRemainingCells) {
  const std::vector<std::string> warnings =
      warnings_with({"incision.cut.depth=0.055", "incision.cut.through_bone=true"});
  ASSERT_EQ(warnings.size(), 2u) << "cells below the cut, and bone";
  EXPECT_NE(warnings[0].find("cells of body below the cut, expected at least 3 cells"), std::string::npos)
      << warnings[0];
}

// A blade that meets bone is said, with the depth of the bone: fat ends 40 mm below the front of the block,
// at y = 18 mm, and the skin of the lattice is at most a spacing inside it.
TEST(LatticeWarnings, BladeInBoneStatesDepth) {
  const std::vector<std::string> warnings = warnings_with({"incision.cut.depth=0.045"});
  const auto bone = std::find_if(warnings.begin(), warnings.end(),
                                 [](const std::string& text) { return text.find("bone") != text.npos; });
  ASSERT_NE(bone, warnings.end());
  double x = 0, y = 0, z = 0, depth = 0;
  ASSERT_EQ(std::sscanf(bone->c_str(), "incision 'cut': the blade meets bone at (%lf, %lf, %lf) m, %lf mm",
                        &x, &y, &z, &depth),
            4)
      << *bone;
  EXPECT_NEAR(y, 0.018, 0.003);
  EXPECT_NEAR(depth, 36, 5);
  for (const std::string& text : warnings_with({"incision.cut.depth=0.025"}))
    EXPECT_EQ(text.find("bone"), text.npos) << text;
}

// Inverted cells are counted.
TEST(LatticeWarnings, CountsInvertedCells) {
  const Scene scene = test::block_scene(test::fresh_folder());
  World world = test::block_world(kExec, scene);
  LatticeBody& body = world.lattice_bodies[0];
  const Lattice& l = body.model.anatomy.lattice;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++)
        body.state.change().motion.u.set(std::size_t(node_slot(l, i, j, k)),
                                         {-2 * rest_position(l, {i, j, k}).x, 0, 0});
  const std::vector<std::string> warnings = lattice_warnings(kExec, world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("block: ")) << warnings[0];
  EXPECT_NE(warnings[0].find("cells are inverted"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace turgor
