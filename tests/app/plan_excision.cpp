// `turgor plan-excision` as a user runs it.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

// A scene without an excision, or without stitches that close it, is refused before anything is simulated.
TEST(PlanExcisionCommand, RefusesScenesWithoutClosure) {
  const fs::path folder = fresh_folder();
  std::ofstream(folder / "cut.toml") << small_scene();
  const Ended cut = run_program("plan-excision cut.toml", folder);
  EXPECT_EQ(cut.code, 2) << cut.printed;
  EXPECT_NE(cut.printed.find("expected one [excision.NAME]"), std::string::npos) << cut.printed;
  std::ofstream(folder / "open.toml")
      << "[world]\nduration = 1\n[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n"
         "[excision.mole]\nbody = \"torso\"\ncenter_fraction = [0.5, 0, 0.5]\nlength = 0.04\nwidth = 0.02\n";
  const Ended open = run_program("plan-excision open.toml", folder);
  EXPECT_EQ(open.code, 2) << open.printed;
  EXPECT_NE(open.printed.find("no suture closes the excision mole"), std::string::npos) << open.printed;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace turgor
