// `turgor plan-excision` as a user runs it.
#include <map>

#include "tests/app/program.hpp"
#include "tests/sim/block_scene.hpp"

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

/// A small block on bone, whose front is at y = −20 mm.
bool write_block(const fs::path& folder) {
  return bool(write_ct(folder / "block.nii", layered_ct({.size = {28, 18, 30},
                                                         .air = {4, 4, 4},
                                                         .origin = {-0.054, -0.036, -0.058},
                                                         .deep_from = 12,
                                                         .deep = 1000})));
}
/// The block as soft tissue whose skin is tense along z. A lens is cut out and closed.
std::string directional_text() {
  return "[world]\nduration = 1\nframe_rate = 50\n"
         "[body.block]\nmodel = \"lattice\"\nct = \"block.nii\"\nblock = 1\nfixed = \"bone\"\n"
         "skin = { tension = [60, 15], stiffness = 300, direction = [0, 0, 1] }\n"
         "[excision.mole]\nbody = \"block\"\ncenter = [0.002, -0.02, 0.001]\ndirection = [0, 0, 1]\n"
         "length = 0.036\nwidth = 0.012\ndepth = 0.01\nstart = 0.02\n"
         "[suture.row]\nwound = \"mole\"\nbite = 0.006\nspacing = 0.008\nstart = 0.1\nduration = 0.3\n";
}

// Bodies whose state a direction would leave to the next one are refused.
TEST(PlanExcisionCommand, RefusesOtherBodies) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_block(folder));
  std::ofstream(folder / "ball.toml") << directional_text()
                                      << "[body.ball]\nmodel = \"rigid\"\nshape = { sphere = 0.005 }\n"
                                         "at = [0, -0.2, 0]\ndensity = 1000\n";
  const Ended ended = run_program("plan-excision ball.toml -o plan", folder);
  EXPECT_EQ(ended.code, 2) << ended.printed;
  EXPECT_NE(ended.printed.find("no other bodies"), std::string::npos) << ended.printed;
}

// The command finds that a lens along the lines of largest tension closes with least force.
TEST(PlanExcisionCommand, LeastForceIsAlongLinesOfTension) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_block(folder));
  std::ofstream(folder / "block.toml") << directional_text();
  const Ended ended = run_program("plan-excision block.toml --directions 2 --ratios 2.5,3 -o plan", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const nlohmann::json plan = report_in(folder / "plan");
  std::map<std::pair<int, int>, nlohmann::json> found;  // by length [mm] and angle [degrees]
  for (const nlohmann::json& lens : plan.at("directions"))
    found[{lens.at("length_mm").get<int>(), lens.at("angle_deg").get<int>()}] = lens;
  ASSERT_EQ(found.size(), 4u);
  for (const int length : {30, 36}) {
    const nlohmann::json &along = found.at({length, 0}), &across = found.at({length, 90});
    EXPECT_NEAR(along.at("angle_to_lines_deg").get<double>(), 0, 1);
    EXPECT_NEAR(across.at("angle_to_lines_deg").get<double>(), 90, 1);
    EXPECT_LT(along.at("closing_force_N").get<double>(), 0.8 * across.at("closing_force_N").get<double>());
    EXPECT_GT(along.at("largest_stretch").get<double>(), 1);
  }
  EXPECT_EQ(plan.at("best_angle_deg"), 0);
  EXPECT_EQ(plan.at("worst_angle_deg"), 90);
  EXPECT_TRUE(fs::exists(folder / "plan" / "closing-force.svg"));
}

// Undermining, which --set adds to the scene, lowers the closing force of the plan.
TEST(PlanExcisionCommand, UnderminingLowersForce) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_block(folder));
  std::ofstream(folder / "block.toml") << directional_text();
  double force[2];
  for (const int n : {0, 1}) {
    const std::string keys =
        n ? "--set excision.mole.undermine.width=0.02 --set excision.mole.undermine.depth=0.006 -o flaps"
          : "-o plain";
    const Ended ended = run_program("plan-excision block.toml --directions 2 " + keys, folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    force[n] = report_in(folder / (n ? "flaps" : "plain"))
                   .at("directions")
                   .at(0)
                   .at("closing_force_N")
                   .get<double>();
  }
  std::printf("closing force %.3f N, %.3f N with flaps\n", force[0], force[1]);
  EXPECT_LT(force[1], force[0]);
}

// A lesion or a ratio that is no lens is refused.
TEST(PlanExcisionCommand, RefusesWrongShapes) {
  const fs::path folder = fresh_folder();
  std::ofstream(folder / "block.toml") << directional_text();
  for (const char* option : {"--ratios 0.5", "--ratios 2,x", "--lesion 0", "--lesion nan"}) {
    const Ended ended = run_program(std::string("plan-excision block.toml ") + option, folder);
    EXPECT_EQ(ended.code, 2) << option << ": " << ended.printed;
    EXPECT_NE(ended.printed.find("expected a number from"), std::string::npos) << ended.printed;
  }
}

}  // namespace
}  // namespace turgor
