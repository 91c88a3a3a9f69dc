// `turgor bench haptics`: the Z-width table, the JSON file of figures and the picture.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

// A local contact model updated at 30 Hz is stable at as many stiffnesses as a wall at 1 kHz; a held force is
// not.
TEST(BenchHaptics, LocalContactWidensZWidth) {
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

// A soak reports ticks, missed ticks and drift, and compares them with an empty loop.
TEST(BenchHaptics, SoakReportsDriftAndMisses) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("bench haptics --minutes 0.05 --json s.json", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("empty loop"), std::string::npos) << ended.printed;
  const json soak = read_json(folder / "s.json");
  for (const char* loop : {"haptic", "empty"}) {
    const json& one = soak[loop];
    EXPECT_NEAR(one["ticks"].get<double>() + one["missed"].get<double>(), 3000, 300) << loop;
  }
  EXPECT_LT(std::abs(soak["drift_ms"].get<double>()), 5) << "ticks are counted by an absolute clock";
  EXPECT_GT(soak["force_max_n"].get<double>(), 0.01) << "the liver exerts a force";
  EXPECT_NEAR(soak["frames"].get<double>(), 180, 20);
}

// Every loop is timed together with an empty one, including rhombus chains at 4 kHz.
TEST(BenchHaptics, TimesLoopsAgainstEmptyLoop) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("bench haptics --seconds 0.2 --json l.json", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json loops = read_json(folder / "l.json")["loops"];
  ASSERT_EQ(loops.size(), 6u);
  for (const json& loop : loops) {
    EXPECT_GT(loop["ticks"].get<double>() + loop["missed"].get<double>(),
              0.15 * loop["target_rate_hz"].get<double>());
    EXPECT_GT(loop["jitter_empty"]["max_us"].get<double>(), 0);
  }
  EXPECT_EQ(loops[5]["model"], "rhombus");
  EXPECT_EQ(loops[5]["target_rate_hz"], 4000);
}

// Two outputs with the same file name are refused.
TEST(BenchHaptics, RejectsEqualOutputFiles) {
  const Ended ended = run_program("bench haptics --json a --picture a", fresh_folder());
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("name the same file"), std::string::npos) << ended.printed;
}

}  // namespace
}  // namespace turgor
