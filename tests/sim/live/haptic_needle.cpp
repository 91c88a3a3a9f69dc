// The safety chain with needles: a hand with a light grip inserts one into finite elements and into a
// lattice.
#include <fmt/format.h>

#include "tests/sim/haptic_hand.hpp"
#include "turgor/sim/live/mouse_tools.hpp"

namespace turgor {
namespace {

constexpr const char* kPads[] = {
    "[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.04], count = [6, 6, 4] }\nfixed = "
    "\"bottom\"\nyoung = 4e3\ncache = false\n[tool.needle]\nbody = \"pad\"\npress = { at = [0.031, 0.028, "
    "0.04], depth = 0.025, ",
    "[body.pad]\nmodel = \"lattice\"\nct = \"pad.nii\"\nblock = 1\nskin = false\ngravity = false\nfixed = { "
    "sides = \"back\" }\ntissue = { young = 1e4 }\n[tool.needle]\nbody = \"pad\"\npress = { at = [0.005, "
    "-0.01, 0.003], depth = 0.025, "};

World needled_world(const char* pad, double rate) {
  const auto folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "pad.nii", test::layered_ct({.size = {24, 20, 24},
                                                             .air = {3, 2, 3},
                                                             .origin = {-0.046, -0.006, -0.046},
                                                             .deep_from = 8,
                                                             .deep = 60})));
  const std::string text = fmt::format(
      "[world]\nduration = 9\nframe_rate = {}\n{}start = 0.1, duration = 0.8, hold = 8 }}\nshape = {{ needle "
      "= "
      "0.06, diameter = 0.001, toughness = 60, entry_toughness = 120 }}\n",
      rate, pad);
  const Result<Scene> scene = parse_scene(text, folder / "pad.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

// A needle that the hand inserts and holds: it punctures the surface, the hand comes to rest, and the device
// receives no force above its limit or its slope, also when the physics stops and when the loop stalls.
TEST(HapticNeedle, SafetyChainKeepsLimitsAndSettles) {
  for (const char* pad : kPads)
    for (const double rate : {100.0, 30.0}) {
      World world = needled_world(pad, rate);
      test::HapticHand hand(world, 0);
      hand.advance(2.0);
      const std::string what = fmt::format("{} at {} Hz", model_name(world.tools[0].body.kind), rate);
      const int punctures = world.lattice_bodies.empty()
                                ? world.sfem_bodies[0].touch.needles.needles[0].punctures
                                : world.lattice_bodies[0].needles[0].punctures;
      EXPECT_EQ(punctures, 1) << what;
      EXPECT_GT(norm(hand.force()), 0.05) << what << " [N]";
      double fastest = 0;
      for (int n = 0; n < 200; n++) hand.advance(0.001), fastest = std::max(fastest, hand.speed());
      EXPECT_LT(fastest, 0.002) << what << ": m/s";
      EXPECT_EQ(hand.safety().counts.not_finite, 0u) << what;
      test::expect_harmless(hand, what);
      hand.has_frames = false;
      hand.advance(0.3);
      hand.stall(0.05);
      hand.has_frames = true;
      hand.advance(0.3);
      test::expect_harmless(hand, what + " after a stall");
    }
}

// The readings of a needle are those of the newest tick, also once the log is full.
TEST(HapticNeedle, FullLogKeepsReadings) {
  for (const char* pad : kPads) {
    World world = needled_world(pad, 50);
    const Result<LiveHands> hands = hold_mouse_tools(world);
    ASSERT_TRUE(hands) << hands.error().message;
    auto live =
        LiveTouch::start(world, hands->held, {.loop = {.priority = 0, .lock_memory = false}, .longest = 0.2});
    ASSERT_TRUE(live) << live.error().message;
    const auto inserted = [&] { return (*live)->haptic()[0].needle.inserted; };
    for (int frame = 0; frame < 300 && inserted() < 0.015; frame++) {
      ASSERT_TRUE(step(Exec(2), world));
      (*live)->wait_for_frame();
    }
    EXPECT_GT(inserted(), 0.015) << "m, " << model_name(world.tools[0].body.kind);
    (*live)->stop();
    EXPECT_LT(world.tools[0].samples.size(), 210u);
  }
}

}  // namespace
}  // namespace turgor
