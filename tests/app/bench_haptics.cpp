// The Z-width as people measure it: a table, a file of figures, a picture.
#include "app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

TEST(BenchHaptics, AContactThatPhysicsTellsThirtyTimesASecondIsAsStiffAsAWallOfTheTickAndAHeldForceIsNot) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("bench haptics --seconds 0 --json z.json --picture z.svg", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json bench = read_json(folder / "z.json");
  const auto resting = [&](const std::string& physics, bool controller) {
    int count = 0;
    for (const json& map : bench["z_width"])
      if (map["physics"] == physics && map["controller"] == controller)
        for (const json& row : map["stable"])
          for (const json& stable : row) count += stable.get<bool>();
    return count;
  };
  for (const bool controller : {false, true}) {
    EXPECT_GT(resting("30 Hz, force held", controller), 0);
    EXPECT_LT(resting("30 Hz, force held", controller), resting("100 Hz, force held", controller));
    EXPECT_LT(resting("100 Hz, force held", controller), resting("1 kHz", controller));
    EXPECT_NEAR(resting("30 Hz, local contact model", controller), resting("1 kHz", controller), 10);
  }
  for (const char* physics : {"1 kHz", "100 Hz, force held", "30 Hz, force held"})
    EXPECT_GT(resting(physics, true), resting(physics, false)) << physics;
  std::ifstream file(folder / "z.svg");
  const std::string svg((std::istreambuf_iterator<char>(file)), {});
  EXPECT_TRUE(svg.starts_with("<?xml") && svg.ends_with("</svg>\n"));
}

TEST(BenchHaptics, TwoOutputsOfOneNameAreRefused) {
  const Ended ended = run_program("bench haptics --json a --picture a", fresh_folder());
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("name the same file"), std::string::npos) << ended.printed;
}

}  // namespace
}  // namespace turgor
