// Bodies that [attachment.NAME] and [contact.NAME] refuse.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

/// Two lattices and a cloth, coupled by a table.
std::string coupled(const std::string& world, const std::string& table, const std::string& solver = "") {
  return fmt::format(
      "[world]\n{}"
      "[body.a]\nmodel = \"lattice\"\nct = {{ phantom = \"torso\" }}\n{}"
      "[body.b]\nmodel = \"lattice\"\nct = {{ phantom = \"leg\" }}\n"
      "[body.c]\nmodel = \"cloth\"\nsheet = {{ corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, 0], "
      "columns = 6, rows = 6 }}\n{}",
      world, solver, table);
}

// Coupled bodies step on the host: the error names the key that moves them there.
TEST(SceneOrgans, CoupledBodiesOnGpuAreRefused) {
  const std::string gpu = "device = \"gpu\"\n";
  const std::string
      touch = "[contact.x]\nbetween = [\"a\", \"b\"]\n",
      tie = "[attachment.x]\nbetween = [\"a\", \"c\"]\nstiffness = 100\n",
      sewn = "[attachment.x]\nbetween = [\"c\", \"ground\"]\nstiffness = 100\nbox = [[0, 0, 0], [1, 1, 1]]\n";
  for (const std::string& table : {touch, tie, sewn})
    EXPECT_EQ(test::error_of(coupled("", table)), "no error");
  const std::string found = test::error_of(coupled(gpu, touch));
  EXPECT_NE(
      found.find("contact.x.between: coupled lattices need world.device = \"cpu\", found \"gpu\", which "
                 "steps a"),
      std::string::npos)
      << found;
  EXPECT_NE(found.find("steps b"), std::string::npos) << found;
  const std::string tied = test::error_of(coupled(gpu, tie));
  EXPECT_NE(tied.find("attachment.x.between: coupled lattices need world.device = \"cpu\""),
            std::string::npos)
      << tied;
  const std::string held = test::error_of(coupled(gpu, sewn));
  EXPECT_NE(held.find("attachment.x.between: attachments of c need body.c.device = \"cpu\", found \"gpu\""),
            std::string::npos)
      << held;
  EXPECT_EQ(test::error_of(coupled(gpu, sewn), {"body.c.device=cpu"}), "no error");
}

// Projections have no springs and contacts at points of their surface.
TEST(SceneOrgans, CoupledProjectionsAreRefused) {
  const std::string found = test::error_of(coupled("", "[contact.x]\nbetween = [\"a\", \"b\"]\n",
                                                   "skin = false\nsolver = { method = \"pbd\" }\n"));
  EXPECT_NE(found.find("contact.x.between: coupled lattices need solver.method = \"vbd\", found \"pbd\" in "
                       "body.a"),
            std::string::npos)
      << found;
}

}  // namespace
}  // namespace turgor
