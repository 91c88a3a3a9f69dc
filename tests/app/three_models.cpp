// One fingertip on all three models, at a small size.
#include <cmath>
#include <numbers>

#include "tests/app/program.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

constexpr const char* kSmall =
    " --set 'body.elements.labels={phantom=\"torso\",size=[72,72,44],spacing_mm=[5.6,5.6,6.9]}'"
    " --set body.elements.resolution=0.028 --set body.elements.cache=false"
    " --set 'body.nodes.ct={phantom=\"torso\",size=[72,72,44],spacing_mm=[5.6,5.6,6.9]}'"
    " --set body.nodes.block=1 --set world.duration=1.1"
    " --set 'output.snapshots={every=0.5,size=[240,180]}'";

// One tool path yields comparable forces and dents in all three models, also in the report and the replay.
TEST(ThreeModels, OnePathHasComparableForces) {
  const fs::path folder = fresh_folder();
  const std::string scene = std::string(TURGOR_SOURCE_DIR) + "/scenes/three-models.toml";
  const Ended ended = run_program("run " + scene + kSmall + " --set output.pictures=all --out first", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json report = report_in(folder / "first");
  ASSERT_EQ(report["costs"].size(), 3u);
  const double elements = report["costs"][0]["force_max_N"].get<double>();
  const std::vector<std::string> models = {"sfem", "rhombus", "lattice"};
  for (std::size_t m = 0; m < 3; m++) {
    const json& cost = report["costs"][m];
    EXPECT_EQ(cost["model"], models[m]);
    EXPECT_NEAR(cost["force_max_N"].get<double>(), elements, 0.35 * elements) << "N, " << models[m];
    EXPECT_NEAR(cost["depth_max_mm"].get<double>(), 9, 0.5) << models[m];
    // On surfaces this coarse the next vertex may be 8 mm away, or half a cell above its node.
    EXPECT_GT(cost["displacement_max_mm"].get<double>(), 4.5) << models[m];
    EXPECT_LT(cost["displacement_max_mm"].get<double>(), 12.5) << models[m];
    EXPECT_GT(report["profiles"][m]["rows"].size(), 5u) << models[m];
  }
  EXPECT_EQ(report["costs"][0]["force_every_ms"], 1.0);
  EXPECT_NEAR(report["costs"][2]["force_every_ms"].get<double>(), 1000.0 / 60, 1e-3);
  EXPECT_EQ(report["tools"][2]["ticks"], 66) << "one force per frame";
  const std::string page = bytes_of(folder / "first" / "report.html");
  for (const char* words :
       {"Comparison of bodies", "Force over time", "Displacement under the largest force", "on-nodes"})
    EXPECT_NE(page.find(words), std::string::npos) << words;

  ASSERT_EQ(run_program("run --replay first/recording.h5 --out again", folder).code, 0);
  for (const char* name : {"forces.csv", "nodes-near.png", "nodes-displacement.png", "nodes-whole.png"})
    EXPECT_TRUE(bytes_of(folder / "first" / name) == bytes_of(folder / "again" / name)) << name;
}

// The shipped scene keeps the forces that docs/validation.md states. All three bodies have one shape, so all
// forces point the same way.
TEST(ThreeModels, ShippedSceneKeepsForces) {
  const fs::path folder = fresh_folder();
  const std::string scene = std::string(TURGOR_SOURCE_DIR) + "/scenes/three-models.toml";
  const Ended ended = run_program(
      "run " + scene + " --set world.duration=0.92 --set body.elements.cache=false --out first", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_EQ(ended.printed.find("cavities"), std::string::npos) << ended.printed;
  const json report = report_in(folder / "first");
  const double stated[] = {0.411, 0.430, 0.539};  // N
  std::vector<Vec3d> force;
  for (std::size_t m = 0; m < 3; m++) {
    const json& tool = report["tools"][m];
    EXPECT_NEAR(tool["force_max_N"].get<double>(), stated[m], 0.03 * stated[m]) << tool["name"];
    const json& last = tool["series"].back();
    force.push_back({last[5].get<double>(), last[6].get<double>(), last[7].get<double>()});
  }
  for (const Vec3d f : force)
    EXPECT_GT(dot(normalized(f), normalized(force[0])), std::cos(10 * std::numbers::pi / 180));
}

}  // namespace
}  // namespace turgor
