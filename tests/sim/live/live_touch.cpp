#include "turgor/sim/live/live_touch.hpp"

#include <atomic>
#include <cmath>

#include "tests/sim/four_kinds.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/report/summary.hpp"

namespace turgor {
namespace {

using test::four_kinds_scene;
using test::fresh_folder;

/// A device that follows a tool's own path, one tick per exchange, regardless of its force.
class PathDevice final : public haptics::Device {
 public:
  explicit PathDevice(const TouchingTool& tool) { tool_.path = tool.path; }
  Status open() override { return Done{}; }
  const haptics::DeviceSpec& spec() const override { return spec_; }
  bool exchange(const haptics::DeviceOutput& output, haptics::DeviceInput& input) noexcept override {
    haptic = std::max(haptic, norm(output.force));
    const contact::ToolCommand wanted = command_at(tool_, double(++ticks_) * kTick);
    input.pose = wanted.pose, input.buttons = wanted.hold ? 1 : 0;
    return true;
  }
  void close() noexcept override {}
  long ticks() const { return ticks_; }

  double haptic = 0;  // [N]

 private:
  TouchingTool tool_;
  std::atomic<long> ticks_ = 0;
  haptics::DeviceSpec spec_{.name = "path", .force = 20, .stiffness = 5000, .damping = 30};
};

using test::kBall;
using test::kFinger;
using test::kTip;

World four_kinds(const std::vector<std::string>& overrides = {}) {
  return test::block_world(Exec(2), four_kinds_scene(fresh_folder(), overrides));
}

/// Runs frames by the clock, with one live tool; the tools' logs are in the world afterwards. A slow machine
/// misses ticks: more frames run until the tool moved for `least_ticks`.
double run_live(World& world, int tool, int frames, long least_ticks = 0) {
  PathDevice device(world.tools[std::size_t(tool)]);
  std::vector<HeldTool> held(1);
  held[0] = {.tool = tool, .hand = {.device = &device}};
  auto live = LiveTouch::start(world, held, {.loop = {.priority = 0, .lock_memory = false}});
  EXPECT_TRUE(live) << live.error().message;
  for (int frame = 0; frame < frames || (device.ticks() < least_ticks && frame < 20 * frames); frame++) {
    EXPECT_TRUE(step(Exec(1), world));
    (*live)->wait_for_frame();
  }
  (*live)->stop();
  return device.haptic;
}

void compare(const TouchLog& haptic, const TouchLog& alone, double tolerance) {
  ASSERT_GT(haptic.size(), 100u);
  double largest = 0, difference = 0;
  for (std::size_t s = 0; s < std::min(haptic.size(), alone.size()); s++) {
    largest = std::max(largest, norm(alone[s].force));
    difference = std::max(difference, norm(haptic[s].force - alone[s].force));
  }
  EXPECT_GT(largest, 1e-3) << "N: the tool is in contact";
  EXPECT_LE(difference, tolerance * largest);
}

// A rhombus body with a live tool has the bits of the offline run.
TEST(LiveTouch, RhombusMatchesOfflineBits) {
  World alone = four_kinds(), live = four_kinds();
  for (int frame = 0; frame < 15; frame++) ASSERT_TRUE(step(Exec(1), alone));
  EXPECT_GT(run_live(live, kBall, 15), 0) << "the device received a force";
  compare(live.tools[kBall].samples, alone.tools[kBall].samples, 0);
}

// An SFEM body with a live tool has the forces of the offline run.
TEST(LiveTouch, SfemMatchesOffline) {
  World alone = four_kinds(), live = four_kinds();
  for (int frame = 0; frame < 15; frame++) ASSERT_TRUE(step(Exec(1), alone));
  run_live(live, kFinger, 15);
  compare(live.tools[kFinger].samples, alone.tools[kFinger].samples,
          0.05);  // cloth and patches are updated by frames
}

// A lattice that a live tool presses and holds has the forces of the offline run. It is held for a minute: on
// a busy machine, 40 frames take longer than their time, and the tool, which follows the clock, would leave.
TEST(LiveTouch, LatticeMatchesOffline) {
  const std::vector<std::string> held = {"tool.tip.press.hold=60", "world.duration=60"};
  World alone = four_kinds(held), live = four_kinds(held);
  for (int frame = 0; frame < 40; frame++) ASSERT_TRUE(step(Exec(1), alone));
  run_live(live, kTip, 40, 600);
  const double expected = norm(alone.tools[kTip].samples.back().force);
  EXPECT_GT(expected, 0.02);
  EXPECT_NEAR(norm(live.tools[kTip].samples.back().force), expected, 0.1 * expected);
}

// A sheet that a live tool presses and holds has the forces of the offline run.
TEST(LiveTouch, ClothMatchesOffline) {
  const std::string text = R"(
[world]
gravity = [0, 0, 0]
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, 0], columns = 10, rows = 10 }
fabric = { law = "springs" }
solver = { method = "two_level" }
damping = { motion = 4 }
collision = { thickness = 0.008 }
hold.left = { box = [[-1, -1, -1], [0.001, 1, 1]] }
hold.right = { box = [[0.099, -1, -1], [1, 1, 1]] }
[tool.ball]
body = "sheet"
shape = { sphere = 0.01 }
path = [[0, 0.05, 0.05, 0.02], [0.3, 0.05, 0.05, 0.001]]
)";
  const Result<Scene> scene = parse_scene(text, "sheet.toml", {});
  ASSERT_TRUE(scene);
  Result<World> alone = load_world(Exec(2), *scene), live = load_world(Exec(2), *scene);
  for (int frame = 0; frame < 60; frame++) ASSERT_TRUE(step(Exec(1), *alone));
  EXPECT_GT(run_live(*live, 0, 60, 900), 0.2) << "N: the device received a force";
  const double expected = norm(alone->tools[0].samples.back().force);
  EXPECT_GT(expected, 0.2) << "N";
  EXPECT_NEAR(norm(live->tools[0].samples.back().force), expected, 0.1 * expected);
}

// Ticks beyond those in memory are on disk; the recording has all of them, in its file too.
TEST(LiveTouch, LongRecordingIsOnDisk) {
  World world = four_kinds({"world.duration=3"});
  PathDevice device(world.tools[kBall]);
  std::vector<HeldTool> held(1);
  held[0] = {.tool = kBall, .hand = {.device = &device}};
  auto live = LiveTouch::start(
      world, held, {.loop = {.priority = 0, .lock_memory = false}, .longest = 3600, .in_memory = 512});
  ASSERT_TRUE(live) << live.error().message;
  for (int frame = 0; frame < 80; frame++) {
    ASSERT_TRUE(step(Exec(1), world));
    (*live)->record_frame_inputs();
    (*live)->wait_for_frame();
  }
  (*live)->stop();
  const Result<HapticRecording> run = (*live)->haptic_recording();
  ASSERT_TRUE(run) << run.error().message;

  // every tick is in the log, in the recording and in the recording's file
  const std::filesystem::path file = fresh_folder() / "haptic.h5";
  ASSERT_TRUE(write_haptic_recording(file, *run));
  const Result<HapticRecording> read = read_haptic_recording(file);
  ASSERT_TRUE(read) << read.error().message;
  for (const int t : {kBall, kFinger, kTip}) {
    const TouchLog& samples = world.tools[std::size_t(t)].samples;
    const DiskLog<HapticTick>&ticks = run->tools[std::size_t(t)].ticks,
          &stored = read->tools[std::size_t(t)].ticks;
    EXPECT_GT(ticks.size(), 512u) << "more than memory holds";
    EXPECT_EQ(ticks.in_memory(), 512u);
    ASSERT_EQ(samples.size(), ticks.size());
    ASSERT_EQ(stored.size(), ticks.size());
    for (std::size_t n = 0; n < ticks.size(); n++) {
      ASSERT_EQ(samples[n].time, ticks[n].time);
      ASSERT_NEAR(ticks[n].time, 1e-3 * std::round(1e3 * ticks[n].time), 1e-9);
      ASSERT_GE(ticks[n].time, (n > 0 ? ticks[n - 1].time : 0) + 0.999e-3) << "missed ticks leave gaps";
      ASSERT_EQ(samples[n].position, ticks[n].command.pose.position);
      ASSERT_EQ(stored[n].time, ticks[n].time);
      ASSERT_EQ(stored[n].command.pose.position, ticks[n].command.pose.position);
      ASSERT_EQ(stored[n].inputs_used.frame, ticks[n].inputs_used.frame);
    }
  }
}

// Frames follow the clock, and the world runs offline again after the end.
TEST(LiveTouch, FramesFollowClock) {
  World world = four_kinds();
  const Timer timer;
  run_live(world, kBall, 10);
  EXPECT_GE(timer.seconds(), 9 * 0.02) << "frames of 20 ms, the first one immediately";
  EXPECT_FALSE(world.sfem_bodies[0].haptic || world.rhombus_bodies[0].haptic);
  EXPECT_EQ(world.frame, 10);
  EXPECT_TRUE(step(Exec(1), world)) << "the world continues without a hand";
  for (const TouchingTool& tool : world.tools) EXPECT_GT(tool.samples.size(), 50u) << tool.name;
}

// Unknown tools and tools with two devices are refused.
TEST(LiveTouch, RejectsUnknownOrSharedTools) {
  World world = four_kinds();
  PathDevice device(world.tools[0]);
  const auto start = [&](std::vector<int> tools) {
    std::vector<HeldTool> held(tools.size());
    for (std::size_t h = 0; h < held.size(); h++) held[h] = {.tool = tools[h], .hand = {.device = &device}};
    return LiveTouch::start(world, held, {.loop = {.priority = 0, .lock_memory = false}});
  };
  EXPECT_FALSE(start({3}));
  EXPECT_FALSE(start({-1}));
  EXPECT_FALSE(start({1, 1}));
  EXPECT_FALSE(start({}));
  EXPECT_FALSE(world.sfem_bodies[0].haptic || world.rhombus_bodies[0].haptic);
}

// A simulated hand follows the path and is pushed back by the tissue.
TEST(LiveTouch, SimulatedHandIsPushedBack) {
  World world = four_kinds({"tool.ball.press.start=1.6", "tool.ball.press.duration=0.5"});
  Result<LiveRun> live = start_live(world, {.tool = "ball"}, 2.8);
  ASSERT_TRUE(live) << live.error().message;
  for (int frame = 0; frame < 125; frame++) {
    ASSERT_TRUE(step(Exec(1), world));
    live->touch->wait_for_frame();
  }
  live->touch->stop();
  double deepest = 0, largest = 0;
  for (const ForceSample& s : world.tools[kBall].samples)
    deepest = std::max(deepest, s.depth), largest = std::max(largest, norm(s.force));
  EXPECT_GT(deepest, 0.002) << "m; the path requests 6 mm, and the hand is soft";
  EXPECT_LT(deepest, 0.0075) << "the hand overshoots slightly";
  EXPECT_GT(largest, 1e-3);
  const Json of_tool = tool_report(four_kinds_scene(fresh_folder()).tools[kBall], world.tools[kBall], world);
  EXPECT_TRUE(of_tool.at("tick_p50_us").is_null()) << "ticks are timed by the loop only";
  const Json report = haptics_report(*live);
  EXPECT_GT(report.at("ticks").get<long>(), 500);
  EXPECT_EQ(report.at("safety").at("not_finite").get<long>(), 0);
  const std::string summary =
      summary_text({{"haptics", report}, {"timing", Json::object()}, {"warnings", Json::array()}}, "out");
  for (const char* row : {"ticks per second", "fraction of ticks missed", "tick period, 99th percentile",
                          "computation per tick, 99th percentile", "latency from pose to force, median",
                          "largest jump of a force between ticks", "safety actions, after the soft start"})
    EXPECT_NE(summary.find(row), std::string::npos) << row << "\n" << summary;
  EXPECT_FALSE(start_live(world, {.tool = "hook"}, 1)) << "no such tool";
  EXPECT_FALSE(start_live(world, {.device = "hovercraft"}, 1)) << "no such device";
}

}  // namespace
}  // namespace turgor
