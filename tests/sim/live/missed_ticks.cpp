// Simulated time of haptic ticks while the loop stalls, with the rate of a device, and without a device.
#include <cmath>

#include "tests/haptics/still_device.hpp"
#include "tests/sim/four_kinds.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/sim/live/live_touch.hpp"

namespace turgor {
namespace {

using haptics::StillDevice;
using test::kBall;
using test::kFinger;

constexpr haptics::LoopParams kPlain{.priority = 0, .lock_memory = false};

/// The finger presses for two seconds; the ball is held by the device of a test.
Scene slow_finger_scene() {
  return test::four_kinds_scene(test::fresh_folder(),
                                {"world.duration=3", "tool.finger.press.start=0.05",
                                 "tool.finger.press.duration=2", "tool.finger.press.hold=0.1"});
}

/// The ball is held away from the liver.
Result<std::unique_ptr<LiveTouch>> hold_ball(World& world, haptics::Device& device,
                                             const haptics::LoopParams& loop = kPlain) {
  std::vector<HeldTool> held(1);
  held[0].tool = kBall, held[0].hand.device = &device;
  held[0].hand.workspace.origin = command_at(world.tools[kBall], 0).pose.position + Vec3d{0, 0, 0.05};
  held[0].hand.safety.ramp = 0.01;
  return LiveTouch::start(world, held, {.loop = loop});
}

void run_frames(World& world, LiveTouch& live, int frames) {
  for (int frame = 0; frame < frames; frame++) {
    ASSERT_TRUE(step(Exec(1), world));
    live.record_frame_inputs();
    live.wait_for_frame();
  }
}

/// Largest displacement of a tool between two samples [m].
double longest_step(const TouchLog& samples) {
  double longest = 0;
  for (std::size_t n = 1; n < samples.size(); n++)
    longest = std::max(longest, norm(samples[n].position - samples[n - 1].position));
  return longest;
}

/// Largest displacement of the path of a tool in a millisecond [m].
double longest_path_step(const TouchingTool& tool) {
  double longest = 0;
  for (int n = 0; n < 2500; n++)
    longest = std::max(
        longest, norm(path_at(tool.path, 1e-3 * (n + 1)).position - path_at(tool.path, 1e-3 * n).position));
  return longest;
}

// A device that blocks once for half a second: ticks have the time of the clock again, a tool on a path is in
// time again and has not jumped, and the recording replays to the same bits.
TEST(MissedTicks, StallKeepsTimeOfClock) {
  const Scene scene = slow_finger_scene();
  World world = test::block_world(Exec(2), scene);
  StillDevice device;
  const auto live = hold_ball(world, device);
  ASSERT_TRUE(live) << live.error().message;
  const Timer timer;
  run_frames(world, **live, 10);
  device.stall_ms = 500;
  run_frames(world, **live, 75);
  (*live)->stop();
  const double seconds = timer.seconds();
  const TouchingTool& finger = world.tools[kFinger];
  const double time = finger.samples.back().time;
  EXPECT_NEAR(time, seconds, 0.1) << "s";
  EXPECT_EQ(world.tools[kBall].samples.back().time, time);
  // on a busy machine ticks are missed again, and the tool is late by less than half of the stall
  EXPECT_LT(norm(finger.samples.back().position - path_at(finger.path, time).position),
            250 * longest_path_step(finger))
      << "m";
  EXPECT_LT(longest_step(finger.samples), 10.001 * longest_path_step(finger)) << "m";

  // replay
  const double force = norm(finger.samples[finger.samples.size() / 2].force);
  Result<HapticRecording> run = (*live)->haptic_recording();
  ASSERT_TRUE(run) << run.error().message;
  set_scene(scene, false, *run);
  World again = test::block_world(Exec(2), scene);
  const auto replay = HapticReplay::begin(again, *run);
  ASSERT_TRUE(replay) << replay.error().message;
  for (int frame = 0; frame < run->frames; frame++) {
    ASSERT_TRUE((*replay)->next_frame(Exec(1)));
    ASSERT_TRUE(step(Exec(1), again));
  }
  (*replay)->end();
  EXPECT_EQ(state_hash(again), run->hash);
  const TouchLog& replayed = again.tools[kFinger].samples;
  ASSERT_EQ(replayed.size(), finger.samples.size());
  EXPECT_EQ(replayed.back().time, time);
  EXPECT_EQ(norm(replayed[replayed.size() / 2].force), force);
}

// A device that calls at 1 kHz: a requested rate of 500 Hz does not double the speed of simulated time.
TEST(MissedTicks, CallingDeviceKeepsSpeedOfTime) {
  World world = test::block_world(Exec(2), slow_finger_scene());
  StillDevice device(haptics::Pacing::kCallback);
  const auto live = hold_ball(world, device, {.rate = 500, .priority = 0, .lock_memory = false});
  ASSERT_TRUE(live) << live.error().message;
  const Timer timer;
  run_frames(world, **live, 25);
  (*live)->stop();
  EXPECT_NEAR(world.tools[kFinger].samples.back().time, timer.seconds(), 0.1) << "s";
  const std::vector<std::string> notes = (*live)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("1000 ticks per second, not 500"), std::string::npos) << notes[0];
}

// Tools on paths go on while the only device is unplugged, and its loss and return are reported at once.
TEST(MissedTicks, PathsGoOnWithoutDevice) {
  World world = test::block_world(Exec(2), slow_finger_scene());
  StillDevice device;
  const auto live = hold_ball(world, device);
  ASSERT_TRUE(live) << live.error().message;
  run_frames(world, **live, 5);
  EXPECT_TRUE((*live)->news().empty());
  device.unplugged = true;
  run_frames(world, **live, 10);
  std::vector<std::string> news = (*live)->news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_NE(news[0].find("still was lost: its cable is out"), std::string::npos) << news[0];
  const int exchanges = device.exchanges;
  device.unplugged = false;
  run_frames(world, **live, 10);
  news = (*live)->news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_NE(news[0].find("still has returned"), std::string::npos) << news[0];
  EXPECT_GT(device.exchanges, exchanges);
  (*live)->stop();
  const TouchingTool& finger = world.tools[kFinger];
  const double time = finger.samples.back().time;
  EXPECT_GT(time, 24 * 0.02 - 0.05) << "s";
  // on a busy machine, the last ticks were missed too
  EXPECT_LT(norm(finger.samples.back().position - path_at(finger.path, time).position),
            100 * longest_path_step(finger))
      << "m, within 0.1 s of the path";
}

}  // namespace
}  // namespace turgor
