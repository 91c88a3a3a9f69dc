// Haptic forces of every model under a press, and with wrong model values.
#include "tests/sim/haptic_hand.hpp"

#include <limits>

namespace turgor {
namespace {

using test::expect_harmless;
using test::HapticHand;

using test::kBall;
using test::kFinger;
using test::kTip;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The tools press within 0.3 s and stay.
World pressed_world(const std::vector<std::string>& more = {}, const std::string& pad = "") {
  std::vector<std::string> overrides = {"world.duration=3"};
  for (const char* tool : {"finger", "ball", "tip"}) {
    const std::string press = std::string("tool.") + tool + ".press.";
    overrides.insert(overrides.end(), {press + "start=0.1", press + "duration=0.3", press + "hold=3"});
  }
  overrides.insert(overrides.end(), more.begin(), more.end());
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::string text = test::four_kinds_text();
  text.replace(text.find("cache = false"), 13, "cache = false\n" + pad);
  const Result<Scene> scene = parse_scene(text, folder / "four.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

const char* model_of(const World& world, int tool) {
  return model_name(world.tools[std::size_t(tool)].body.kind);
}

/// Multiplies the forces of a model from the next frame on; `times` may be NaN.
void scale_force(World& world, int tool, double times) {
  if (tool == kFinger) world.sfem_bodies[0].stiffness_scale = times;
  if (tool == kBall) {
    rhombus::Model& model = world.rhombus_bodies[0].model;
    model.stiffness.assign(model.surface.vertices.size(), times);
    model.stiffness_gradient.assign(model.surface.vertices.size(), {});
  }
  if (tool != kTip) return;
  contact::LocalContact plane{.is_near = true, .origin = world.lattice_bodies[0].poses[0].pose.position};
  plane.normal = world.lattice_bodies[0].poses[0].pose.axes.column[2];
  plane.force = plane.normal * (times * norm(world.lattice_bodies[0].forces[0].force));
  plane.stiffness = 100 * times, plane.friction = 0.3, plane.reach = 0.1;
  publish_contact(world.lattice_bodies[0], 0, plane);
}

// The hand settles on every model with physics at 100 Hz and at 30 Hz.
TEST(HapticHand, SettlesOnEveryModel) {
  for (const char* rate : {"100", "30"})
    for (const int tool : {kFinger, kBall, kTip}) {
      World world = pressed_world({std::string("world.frame_rate=") + rate});
      HapticHand hand(world, tool);
      hand.advance(2.0);
      const std::string what = std::string(model_of(world, tool)) + " at " + rate + " Hz";
      EXPECT_GT(norm(hand.force()), 0.05) << what << " [N]";
      double fastest = 0;
      for (int n = 0; n < 200; n++) hand.advance(0.001), fastest = std::max(fastest, hand.speed());
      EXPECT_LT(fastest, 0.002) << what << ": m/s, residual motion by encoder steps";
      expect_harmless(hand, what);
    }
}

// The hand settles over a nodule that is a hundred times as stiff, with a larger force.
TEST(HapticHand, SettlesOnStiffNodule) {
  const auto press = [](const std::string& pad) {
    World world = pressed_world({"world.frame_rate=30"}, pad);
    HapticHand hand(world, kFinger);
    hand.advance(2.0);
    const double force = norm(hand.force());
    double fastest = 0;
    for (int n = 0; n < 200; n++) hand.advance(0.001), fastest = std::max(fastest, hand.speed());
    EXPECT_LT(fastest, 0.002) << "m/s";
    expect_harmless(hand, pad);
    return force;
  };
  const double plain = press(""), hard = press(
                                      "inclusion.nodule = { center = [0.018, 0.03, 0.02], radius = 0.012, "
                                      "young = 5e5 }");
  EXPECT_GT(hard, 1.3 * plain) << "N, for the same target depth";
}

// A model with NaN gives no force, and its force returns when it recovers.
TEST(HapticHand, NanGivesNoForceUntilRecovery) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.advance(1.5);
    const double before = norm(hand.force());
    ASSERT_GT(before, 0.05) << model_of(world, tool);
    scale_force(world, tool, kNan);
    hand.has_frames = tool != kTip;  // otherwise the next frame would overwrite it
    hand.advance(0.05);
    if (tool != kBall) {  // the chain's force limit replaces NaN
      EXPECT_GT(hand.safety().counts.not_finite, 10u) << model_of(world, tool);
    }
    EXPECT_EQ(norm(hand.force()), 0) << model_of(world, tool);
    expect_harmless(hand, model_of(world, tool));
    if (tool == kTip) continue;  // its proxy is undefined: see LocalTouch
    scale_force(world, tool, 1);
    hand.advance(1.5);
    EXPECT_NEAR(norm(hand.force()), before, 0.1 * before) << model_of(world, tool);
  }
}

// Forces that are 1e12 times too large are limited in magnitude and slope.
TEST(HapticHand, ExcessiveForcesAreLimited) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.advance(1.5);
    double requested_force = 0;
    scale_force(world, tool, 1e12);
    for (int n = 0; n < 800; n++) {
      hand.advance(0.001, [&] { scale_force(world, tool, 1e12); });
      requested_force = std::max(requested_force, norm(hand.requested_force()));
    }
    const std::string what = model_of(world, tool);
    // A chain limits its force to 30 N; the planes of lattice frames are blended in at 20 N per second.
    EXPECT_GT(requested_force, tool == kFinger ? 1e9 : 10.0) << what << " [N]";
    EXPECT_GT(hand.largest, 0.9) << what << ": the force is present";
    expect_harmless(hand, what);
    if (tool == kTip) continue;
    EXPECT_GT(hand.safety().counts.slewed, 3u) << what;
  }
}

// Forces that jump between frames are limited in slope.
TEST(HapticHand, JumpingForcesAreSlewLimited) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.advance(1.5);
    int frame = 0;
    hand.advance(0.5, [&] { scale_force(world, tool, frame++ % 2 == 0 ? 300 : 1); });
    expect_harmless(hand, model_of(world, tool));
    if (tool == kTip) continue;  // the planes of frames are blended in
    EXPECT_GT(hand.safety().counts.slewed, 10u) << model_of(world, tool);
  }
}

// A loop that stalls during a press resumes without a jump.
TEST(HapticHand, StallsCauseNoJump) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.advance(0.3);  // on the approach
    for (int n = 0; n < 5; n++) hand.stall(0.1), hand.advance(0.05);
    hand.advance(0.5);
    EXPECT_GT(norm(hand.force()), 0.05) << model_of(world, tool);
    expect_harmless(hand, model_of(world, tool));
  }
}

// If the physics stops, the force becomes damping and then zero.
TEST(HapticHand, StoppedPhysicsFadesOut) {
  World world = pressed_world();
  HapticHand hand(world, kTip);  // the other models respond within the tick
  hand.advance(1.5);
  ASSERT_GT(norm(hand.force()), 0.05);
  hand.has_frames = false;
  hand.advance(1.5);
  EXPECT_GT(hand.reading.age, 1.0) << "s: the tick reports the age";
  EXPECT_GT(hand.safety().counts.silent, 1000u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "lattice");
}

}  // namespace
}  // namespace turgor
