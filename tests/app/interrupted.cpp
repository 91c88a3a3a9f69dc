// Runs that a signal ends, and what goes on from them.
#include "tests/app/pressed_pad.hpp"
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

/// Starts the program in the background, waits until a file is not empty, and ends it by a signal.
Ended run_and_kill(const std::string& arguments, const std::string& file, const std::string& signal,
                   const fs::path& folder) {
  // after a semicolon: the shell stays in the folder, and $! is the program itself
  return run_shell(
      "true; '" TURGOR_PROGRAM "' " + arguments + " 2>&1 & p=$!; n=0; while [ ! -s " + file +
          " ] && kill -0 $p && [ $n -lt 600 ]; do sleep 0.1; n=$((n+1)); done; sleep 0.2; kill -" + signal +
          " $p; wait $p",
      folder);
}

std::vector<std::string> hidden_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (const std::string name = entry.path().filename().string(); name.starts_with("."))
      names.push_back(name);
  return names;
}

// A run that a signal ended after an autosave says so, goes on with --resume, and ends with the same bits.
TEST(Interrupted, RunGoesOnFromAutosave) {
  const fs::path folder = fresh_folder();
  write(folder / "torso.toml", small_scene());
  const std::string longer = "run torso.toml -q --set world.duration=8 --set output.snapshots.every=2 ";
  const Ended killed =
      run_and_kill(longer + "--out o --autosave 0.01", ".o.autosave-*/state", "TERM", folder);
  EXPECT_NE(killed.printed.find("--resume goes on at"), std::string::npos) << killed.printed;
  ASSERT_FALSE(fs::exists(folder / "o"));
  ASSERT_EQ(hidden_in(folder).size(), 1u);

  const Ended other = run_program("run torso.toml -q --out o --resume", folder);
  EXPECT_EQ(other.code, 2) << other.printed;
  EXPECT_NE(other.printed.find("of another scene, or of other --set"), std::string::npos) << other.printed;
  const Ended resumed = run_program("--threads 1 " + longer + "--out o --resume", folder);
  EXPECT_EQ(resumed.code, 0) << resumed.printed;
  EXPECT_NE(resumed.printed.find("resuming at"), std::string::npos) << resumed.printed;
  EXPECT_TRUE(hidden_in(folder).empty());
  const Ended whole = run_program(longer + "--out whole", folder);
  EXPECT_EQ(whole.code, 0) << whole.printed;
  EXPECT_EQ(report_in(folder / "o")["state_hash"], report_in(folder / "whole")["state_hash"]);
  EXPECT_EQ(report_in(folder / "o")["wounds"], report_in(folder / "whole")["wounds"]);
  EXPECT_EQ(run_program("run torso.toml --out o --resume --check", folder).code, 2);
}

// The log of a killed run in real time gets a name at the next run, and replays.
TEST(Interrupted, HapticLogReplays) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", pressed_pad_text(60, 0.1));
  (void)run_and_kill("run pad.toml --real-time -q --out o", ".o.haptic-*", "KILL", folder);
  ASSERT_FALSE(fs::exists(folder / "o"));
  const Ended next = run_program("run pad.toml -q --set world.duration=0.1 --out o", folder);
  EXPECT_EQ(next.code, 0) << next.printed;
  EXPECT_NE(next.printed.find("o.haptic-log repeats it"), std::string::npos) << next.printed;
  EXPECT_TRUE(hidden_in(folder).empty());
  const Ended replayed = run_program("replay o.haptic-log --out again", folder);
  EXPECT_EQ(replayed.code, 0) << replayed.printed;
  EXPECT_NE(replayed.printed.find("the run was interrupted"), std::string::npos) << replayed.printed;
  const nlohmann::json report = report_in(folder / "again");
  EXPECT_GT(report["haptic_replay"]["frames"].get<int>(), 5);
  EXPECT_FALSE(report["haptic_replay"].contains("same_bits"));
}

}  // namespace
}  // namespace turgor
