#include "turgor/sim/live/mouse_tools.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "turgor/haptics/safety.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

constexpr const char* kFlagAndPad = R"(
[world]
duration = 1
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.3, 0, 0], up = [0, 0, 0.2], columns = 6, rows = 4 }
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [4, 4, 2] }
fixed = "bottom"
cache = false
)";

// Every touchable body without a tool has a fingertip. It waits where neither a wound opens up to it nor a
// cloth that swings on any of its edges reaches it.
TEST(MouseTools, FingertipWaitsOutOfReach) {
  const Result<Scene> scene = parse_scene(kFlagAndPad, "flag.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<World> world = load_world(Exec(1), with_mouse_tools(*scene));
  ASSERT_TRUE(world) << world.error().message;
  ASSERT_EQ(world->tools.size(), 2u);
  for (const TouchingTool& tool : world->tools) {
    const bool is_flag = tool.name == "finger-flag";
    EXPECT_TRUE(is_flag || tool.name == "finger-pad") << tool.name;
    const Vec3d waits = tool.path.rows.front().position;
    EXPECT_LT(waits.y, is_flag ? -0.5 : -0.05) << "m in front of " << tool.name;
  }
}

// A scene's own tool is driven by the mouse; its body gets no fingertip.
TEST(MouseTools, OwnToolOfBodyIsHeld) {
  const std::string text =
      std::string(kFlagAndPad) +
      "[tool.ball]\nbody = \"flag\"\nshape = { sphere = 0.01 }\npath = [[0, 0.1, 1, 0]]\n";
  const Result<Scene> scene = parse_scene(text, "flag.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<World> world = load_world(Exec(1), with_mouse_tools(*scene));
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->tools.size(), 2u);
  const Result<LiveHands> hands = hold_mouse_tools(*world);
  ASSERT_TRUE(hands) << hands.error().message;
  ASSERT_EQ(hands->held.size(), 2u);
  for (const HeldTool& held : hands->held) {
    const std::string& name = world->tools[std::size_t(held.tool)].name;
    EXPECT_TRUE(name == "ball" || name == "finger-pad") << name;
    EXPECT_FALSE(*held.is_driven) << "it follows its path until the mouse moves it";
  }
}

// A pause holds the tool in the equilibrium of its press: it does not sink in, and no larger force follows.
TEST(MouseTools, PauseHoldsPress) {
  const Result<Scene> scene = parse_scene(
      std::string(kFlagAndPad).substr(std::string(kFlagAndPad).find("[body.pad]")) + "young = 5e4\n",
      "pad.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(1), with_mouse_tools(*scene));
  ASSERT_TRUE(world) << world.error().message;
  const Result<LiveHands> hands = hold_mouse_tools(*world);
  ASSERT_TRUE(hands) << hands.error().message;
  auto live = LiveTouch::start(*world, hands->held, {.loop = {.priority = 0, .lock_memory = false}});
  ASSERT_TRUE(live) << live.error().message;
  const auto play = [&](double seconds) {
    for (const double end = time_of(*world) + seconds; time_of(*world) < end;) {
      ASSERT_TRUE(step(Exec(1), *world));
      (*live)->wait_for_frame();
    }
  };
  // a press of 6 mm
  constexpr double kTop = 0.03, kRadius = 0.008;  // of the pad, of the fingertip [m]
  hands->mouse[0].device->set_target({.pose = {{0.03, 0.03, kTop + kRadius - 0.006}, {}},
                                      .teleports = 1,
                                      .teleport_to = {0.03, 0.03, kTop + kRadius + 0.002}});
  play(1);
  const double steady = norm((*live)->haptic()[0].reading.force);
  EXPECT_GT(steady, 0.5) << "N";
  // pause
  (*live)->set_pace(0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  (*live)->set_pace(1);
  play(0.3);
  (*live)->stop();
  const TouchLog& samples = world->tools[0].samples;
  ASSERT_GT(samples.size(), 100u);
  double largest = 0;
  for (std::size_t n = samples.size() / 2; n < samples.size(); n++)
    largest = std::max(largest, norm(samples[n].force));
  EXPECT_LT(largest, 1.2 * steady) << "N";
}

// A force of an old frame supports the tool until the next frame, however late: no hand feels it.
TEST(MouseTools, LateFrameKeepsSupport) {
  const Result<Scene> scene = parse_scene(kFlagAndPad, "flag.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<World> world = load_world(Exec(1), with_mouse_tools(*scene));
  ASSERT_TRUE(world) << world.error().message;
  const Result<LiveHands> hands = hold_mouse_tools(*world);
  ASSERT_TRUE(hands) << hands.error().message;
  for (const HeldTool& held : hands->held) {
    haptics::Safety safety = haptics::make_safety(held.hand.device->spec(), held.hand.safety);
    const auto force_after = [&](double force, double age, int ticks) {
      Vec3d rendered;
      for (int tick = 0; tick < ticks; tick++)
        rendered = make_safe(safety, {.hand = {}, .wanted = {.force = {0, 0, force}}, .age = age}, 1e-3)
                       .value()
                       .force;
      return rendered.z;
    };
    force_after(0, 0, 10);
    EXPECT_NEAR(force_after(2, 0, 300), 2, 1e-9) << "N";
    EXPECT_NEAR(force_after(2, 0.2, 500), 2, 1e-9) << "N: after a frame of 200 ms";
    EXPECT_NEAR(force_after(2, 0, 10), 2, 1e-9) << "N: without another soft start";
  }
}

}  // namespace
}  // namespace turgor
