// Runs in real time from the command line.
#include "tests/app/pressed_pad.hpp"
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

// A run with a virtual device reports the timing of its haptic loop and follows the clock.
TEST(RealTime, ReportsHapticLoop) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(1.5, 1));
  const Ended ended = run_program(
      "run pad.toml --real-time --out o --require 'haptics.ticks>500' --require "
      "'tools.finger.force_max_N>0'",
      folder);
  EXPECT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("the haptic loop"), std::string::npos) << ended.printed;
  const nlohmann::json report = report_in(folder / "o"), &haptics = report["haptics"];
  EXPECT_EQ(haptics["device"], "virtual");
  EXPECT_NEAR(haptics["rate_per_s"].get<double>(), 1000, 100);
  EXPECT_GE(haptics["seconds"].get<double>(), 1.4) << "s: the run follows the clock";
  EXPECT_GT(report["tools"][0]["depth_max_mm"].get<double>(), 0.5) << "the hand followed its path";
  EXPECT_FALSE(fs::exists(folder / "o" / "video.mp4"));
}

// A haptic recording replays to the same bits without the clock.
TEST(RealTime, ReplayReachesEqualState) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(1.5, 1));
  const Ended haptic = run_program("run pad.toml --real-time -q --out o", folder);
  ASSERT_EQ(haptic.code, 0) << haptic.printed;
  const Ended again = run_program("--threads 1 replay o/haptic.h5 --out again", folder);
  EXPECT_EQ(again.code, 0) << again.printed;
  EXPECT_NE(again.printed.find("gave the same state"), std::string::npos) << again.printed;
  const nlohmann::json report = report_in(folder / "again");
  EXPECT_TRUE(report["haptic_replay"]["same_bits"].get<bool>());
  EXPECT_EQ(report["state_hash"], report_in(folder / "o")["state_hash"]);
  EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0);
  const Ended none = run_program("replay pad.toml", folder);
  EXPECT_EQ(none.code, 2) << none.printed;
  EXPECT_NE(none.printed.find("pad.toml"), std::string::npos) << none.printed;
}

// A failed requirement ends the run with code 3 and keeps its results.
TEST(RealTime, FailedRequirementKeepsResults) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(1.5, 1));
  const Ended ended =
      run_program("run pad.toml -q --out o --set world.duration=0.1 --require 'timing.frames<5'", folder);
  EXPECT_EQ(ended.code, 3) << ended.printed;
  EXPECT_NE(ended.printed.find("required timing.frames<5, found 5"), std::string::npos) << ended.printed;
  EXPECT_TRUE(fs::exists(folder / "o" / "report.json"));
}

// Unknown tools and devices are refused before any file is written.
TEST(RealTime, RejectsUnknownNamesEarly) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(1.5, 1));
  for (const char* what : {"--real-time --tool hook", "--real-time --device hovercraft", "--device virtual",
                           "--real-time --device replay", "--require haptics"}) {
    const Ended ended = run_program(std::string("run pad.toml -q --out o ") + what, folder);
    EXPECT_EQ(ended.code, 2) << what << ended.printed;
    EXPECT_FALSE(fs::exists(folder / "o")) << what;
  }
}

// Options that the chosen device, or a check of the scene, would ignore are refused.
TEST(RealTime, RejectsOptionsWithoutEffect) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(1.5, 1));
  write(folder / "poses.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n");
  for (const auto& [what, named] : {std::pair{"--real-time --device-file poses.csv", "--device-file"},
                                    {"--real-time --device dhd --device-file poses.csv", "--device dhd"},
                                    {"--real-time --device-address host:1", "--device-address"},
                                    {"--check --require 'timing.frames<5'", "--require"},
                                    {"--check --real-time", "--real-time"}}) {
    const Ended ended = run_program(std::string("run pad.toml -q --out o ") + what, folder);
    EXPECT_EQ(ended.code, 2) << what << ended.printed;
    EXPECT_NE(ended.printed.find(named), std::string::npos) << what << ended.printed;
    EXPECT_FALSE(fs::exists(folder / "o")) << what;
  }
}

}  // namespace
}  // namespace turgor
