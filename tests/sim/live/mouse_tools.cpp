#include "turgor/sim/live/mouse_tools.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace turgor
