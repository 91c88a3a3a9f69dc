#include "turgor/sim/live/haptic_log.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>

#include "tests/sim/four_kinds.hpp"
#include "turgor/haptics/virtual_device.hpp"
#include "turgor/sim/live/live_run.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A haptic run of a few frames with its log and its recording at the end.
struct LoggedRun {
  fs::path log;
  HapticRecording recording;
};

LoggedRun logged_run(const fs::path& folder, int frames) {
  const Exec exec(1);
  const Scene scene = test::four_kinds_scene(folder);
  World world = load_world(exec, scene).value();
  LiveRun live = start_live(world, {}, scene.duration).value();
  live.touch->begin_log(folder / "out", scene);
  for (int frame = 0; frame < frames; frame++) {
    EXPECT_TRUE(step(exec, world));
    live.touch->record_frame_inputs();
    live.touch->wait_for_frame();
  }
  live.touch->stop();
  return {live.touch->log()->path(), live.touch->haptic_recording().value()};
}

bool is_same(const HapticTick& a, const HapticTick& b) {
  return a.time == b.time && a.step == b.step && a.command.pose.position == b.command.pose.position &&
         a.command.grip == b.command.grip && a.inputs_used.frame == b.inputs_used.frame &&
         a.inputs_used.patch == b.inputs_used.patch && a.inputs_used.solution == b.inputs_used.solution;
}

// A log has all frames of a run with the ticks that they used, and its scene.
TEST(HapticLog, HasFramesAndTicksOfRun) {
  const LoggedRun run = logged_run(test::fresh_folder(), 12);
  const Result<HapticRecording> log = read_haptic_recording(run.log);
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_FALSE(log->has_hash);
  EXPECT_EQ(log->text, test::four_kinds_text());
  ASSERT_TRUE(scene_of(*log));
  ASSERT_GE(log->frames, 11) << "ticks of the last frame may follow it";
  ASSERT_EQ(log->tools.size(), run.recording.tools.size());
  for (std::size_t t = 0; t < log->tools.size(); t++) {
    const HapticTool &logged = log->tools[t], &recorded = run.recording.tools[t];
    EXPECT_EQ(logged.name, recorded.name);
    ASSERT_EQ(logged.frames.size(), std::size_t(log->frames));
    ASSERT_LE(logged.ticks.size(), recorded.ticks.size());
    EXPECT_GE(logged.ticks.size(), std::size_t(logged.frames.back().ticks));
    EXPECT_GT(logged.ticks.size(), 50u);
    EXPECT_TRUE(std::equal(logged.ticks.begin(), logged.ticks.end(), recorded.ticks.begin(), is_same));
  }
}

// A log that is cut short anywhere has fewer frames, or gives a sentence; a damaged one gives a sentence.
TEST(HapticLog, ReadsUnfinishedLog) {
  const fs::path folder = test::fresh_folder(), file = folder / "cut.haptic-log";
  const std::string whole = test::bytes_of(logged_run(folder, 8).log);
  const auto frames_of = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    const Result<HapticRecording> log = read_haptic_recording(file);
    if (!log) {
      EXPECT_NE(log.error().message.find(file.string()), std::string::npos) << log.error().message;
    }
    return log ? log->frames : 0;
  };
  const int all = frames_of(whole);
  EXPECT_GE(all, 7);
  int last = 0;
  for (std::size_t length = 0; length < whole.size(); length += 997) {
    const int frames = frames_of(whole.substr(0, length));
    EXPECT_GE(frames, last);
    EXPECT_LE(frames, all);
    last = frames;
  }
  EXPECT_GE(last, all - 1);
  for (const char* mark : {"FRAM", "\"tools\"", "turgor haptic log"}) {
    std::string damaged = whole;
    damaged[damaged.find(mark)] = '?';
    EXPECT_EQ(frames_of(damaged), 0) << mark;
  }
}

// A log of the first format is read; its ticks used no solutions of a thread, and lattices had whole cells.
TEST(HapticLog, ReadsFirstFormat) {
  const Result<HapticRecording> log =
      read_haptic_recording(TURGOR_SOURCE_DIR "/tests/fuzz/corpus/haptic_log/two-frames");
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_EQ(log->frames, 2);
  EXPECT_TRUE(log->has_whole_cells);
  ASSERT_FALSE(log->tools.empty());
  ASSERT_GT(log->tools[0].ticks.size(), 0u);
  for (const HapticTick& tick : log->tools[0].ticks) {
    EXPECT_EQ(tick.inputs_used.solution, -1);
    EXPECT_GT(tick.step, 0);
  }
}

// Logs of ended runs get visible names; that of a running process stays.
TEST(HapticLog, KeepsLogsOfEndedRuns) {
  const fs::path folder = test::fresh_folder();
  const int ended = 4194303;  // above the largest process id of most systems
  const auto log_of = [&](int process, const char* number) {
    return folder / (".out.haptic-" + std::to_string(process) + number);
  };
  std::ofstream(log_of(ended, "-0")) << "one";
  std::ofstream(log_of(ended, "-1")) << "two";
  std::ofstream(log_of(getpid(), "-0")) << "present";
  const std::vector<std::string> sentences = keep_haptic_logs(folder / "out");
  ASSERT_EQ(sentences.size(), 2u);
  EXPECT_NE(sentences[0].find("turgor replay " + (folder / "out.haptic-log").string()), std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "out.haptic-log") && fs::exists(folder / "out.haptic-log-2"));
  EXPECT_TRUE(fs::exists(log_of(getpid(), "-0")));
}

}  // namespace
}  // namespace turgor
