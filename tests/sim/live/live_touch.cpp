#include "turgor/sim/live/live_touch.hpp"

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

/// A device that goes a tool's own path, a tick an exchange, whatever it is made to feel.
class PathDevice final : public haptics::Device {
 public:
  explicit PathDevice(const TouchingTool& tool) { way_.path = tool.path; }
  Status open() override { return Done{}; }
  const haptics::DeviceSpec& spec() const override { return spec_; }
  bool exchange(const haptics::DeviceOutput& output, haptics::DeviceInput& input) noexcept override {
    haptic = std::max(haptic, norm(output.force));
    const contact::ToolCommand wanted = command_at(way_, double(++ticks_) * kTick);
    input.pose = wanted.pose, input.buttons = wanted.hold ? 1 : 0;
    return true;
  }
  void close() noexcept override {}

  double haptic = 0;  // [N]

 private:
  TouchingTool way_;
  long ticks_ = 0;
  haptics::DeviceSpec spec_{.name = "path", .force = 20, .stiffness = 5000, .damping = 30};
};

using test::kBall;
using test::kFinger;
using test::kTip;

World four_kinds(const std::vector<std::string>& overrides = {}) {
  return test::block_world(Exec(2), four_kinds_scene(fresh_folder(), overrides));
}

/// Frames by the clock, with one tool in a hand; the tools' logs are in the world afterwards.
double feel(World& world, int tool, int frames) {
  PathDevice device(world.tools[std::size_t(tool)]);
  std::vector<HeldTool> held(1);
  held[0] = {.tool = tool, .hand = {.device = &device}};
  auto live = LiveTouch::start(world, held, {.loop = {.priority = 0, .lock_memory = false}});
  EXPECT_TRUE(live) << live.error().message;
  for (int frame = 0; frame < frames; frame++) {
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
  EXPECT_GT(largest, 1e-3) << "N: it touches";
  EXPECT_LE(difference, tolerance * largest);
}

TEST(LiveTouch, a_chain_in_a_hand_answers_the_path_with_the_bits_of_a_run_without_one) {
  World alone = four_kinds(), live = four_kinds();
  for (int frame = 0; frame < 15; frame++) ASSERT_TRUE(step(Exec(1), alone));
  EXPECT_GT(feel(live, kBall, 15), 0) << "the device was made to feel it";
  compare(live.tools[kBall].samples, alone.tools[kBall].samples, 0);
}

TEST(LiveTouch, a_pad_in_a_hand_answers_as_in_a_run_without_one) {
  World alone = four_kinds(), live = four_kinds();
  for (int frame = 0; frame < 15; frame++) ASSERT_TRUE(step(Exec(1), alone));
  feel(live, kFinger, 15);
  compare(live.tools[kFinger].samples, alone.tools[kFinger].samples,
          0.05);  // cloth and patches come by frames
}

TEST(LiveTouch, a_lattice_that_is_pressed_and_held_answers_as_in_a_run_without_a_hand) {
  const std::vector<std::string> held = {"tool.tip.press.hold=1.2", "world.duration=1.2"};
  World alone = four_kinds(held), live = four_kinds(held);
  for (int frame = 0; frame < 40; frame++) ASSERT_TRUE(step(Exec(1), alone));
  feel(live, kTip, 40);
  const double expected = norm(alone.tools[kTip].samples.back().force);
  EXPECT_GT(expected, 0.02);
  EXPECT_NEAR(norm(live.tools[kTip].samples.back().force), expected, 0.1 * expected);
}

TEST(LiveTouch, a_sheet_that_is_pressed_and_held_answers_as_in_a_run_without_a_hand) {
  const std::string text = R"(
[world]
gravity = [0, 0, 0]
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, 0], columns = 10, rows = 10 }
solver = { method = "blocks" }
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
  EXPECT_GT(feel(*live, 0, 60), 0.2) << "N: the device was made to feel it";
  const double expected = norm(alone->tools[0].samples.back().force);
  EXPECT_GT(expected, 0.2) << "N";
  EXPECT_NEAR(norm(live->tools[0].samples.back().force), expected, 0.1 * expected);
}

TEST(LiveTouch, frames_wait_for_the_clock_and_the_world_is_its_own_again_at_the_end) {
  World world = four_kinds();
  const Timer timer;
  feel(world, kBall, 10);
  EXPECT_GE(timer.seconds(), 9 * 0.02) << "frames of 20 ms, the first one at once";
  EXPECT_FALSE(world.sfem_bodies[0].haptic || world.rhombus_bodies[0].haptic);
  EXPECT_EQ(world.frame, 10);
  EXPECT_TRUE(step(Exec(1), world)) << "goes on without a hand";
  for (const TouchingTool& tool : world.tools) EXPECT_GT(tool.samples.size(), 50u) << tool.name;
}

TEST(LiveTouch, a_tool_that_is_not_there_or_in_two_hands_is_refused) {
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

TEST(LiveTouch, a_simulated_hand_goes_the_path_and_is_pushed_back) {
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
  EXPECT_GT(deepest, 0.002) << "m; the path asks for 6 mm, the hand is as soft as a hand";
  EXPECT_LT(deepest, 0.0075) << "it swings a little past where it wants to be";
  EXPECT_GT(largest, 1e-3);
  const Json of_tool = tool_report(four_kinds_scene(fresh_folder()).tools[kBall], world.tools[kBall], world);
  EXPECT_TRUE(of_tool.at("tick_p50_us").is_null()) << "no tick was timed: that is the loop's to tell";
  const Json report = haptics_report(*live);
  EXPECT_GT(report.at("ticks").get<long>(), 500);
  EXPECT_EQ(report.at("safety").at("not_finite").get<long>(), 0);
  const std::string told =
      summary_text({{"haptics", report}, {"timing", Json::object()}, {"warnings", Json::array()}}, "out");
  for (const char* row :
       {"ticks a second", "ticks missed, of 1", "from tick to tick, 99 of 100", "work of a tick, 99 of 100",
        "from pose to force, median", "largest jump of a force from tick to tick",
        "safety actions, after the soft start"})
    EXPECT_NE(told.find(row), std::string::npos) << row << "\n" << told;
  EXPECT_FALSE(start_live(world, {.tool = "hook"}, 1)) << "no such tool";
  EXPECT_FALSE(start_live(world, {.device = "hovercraft"}, 1)) << "no such device";
}

}  // namespace
}  // namespace turgor
