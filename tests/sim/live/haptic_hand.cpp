// What a hand is given by each of the models when it presses, and when the model goes wrong.
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

/// Presses within 0.3 s and stays.
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

/// What a model answers is so many times what it should be, from the next frame on; NaN likewise.
void spoil(World& world, int tool, double times) {
  if (tool == kFinger) world.sfem_bodies[0].stiffer = times;
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
  leave_plane(world.lattice_bodies[0], 0, plane);
}

TEST(HapticHand, it_comes_to_rest_on_every_model_with_physics_of_a_hundred_and_of_thirty_hertz) {
  for (const char* rate : {"100", "30"})
    for (const int tool : {kFinger, kBall, kTip}) {
      World world = pressed_world({std::string("world.frame_rate=") + rate});
      HapticHand hand(world, tool);
      hand.extrapolate(2.0);
      const std::string what = std::string(model_of(world, tool)) + " at " + rate + " Hz";
      EXPECT_GT(norm(hand.force()), 0.05) << what << " [N]";
      double fastest = 0;
      for (int n = 0; n < 200; n++) hand.extrapolate(0.001), fastest = std::max(fastest, hand.speed());
      EXPECT_LT(fastest, 0.002) << what << ": m/s, what encoder steps alone may keep moving";
      expect_harmless(hand, what);
    }
}

TEST(HapticHand, it_comes_to_rest_on_a_nodule_a_hundred_times_as_stiff_and_feels_that_it_is_there) {
  const auto press = [](const std::string& pad) {
    World world = pressed_world({"world.frame_rate=30"}, pad);
    HapticHand hand(world, kFinger);
    hand.extrapolate(2.0);
    const double force = norm(hand.force());
    double fastest = 0;
    for (int n = 0; n < 200; n++) hand.extrapolate(0.001), fastest = std::max(fastest, hand.speed());
    EXPECT_LT(fastest, 0.002) << "m/s";
    expect_harmless(hand, pad);
    return force;
  };
  const double plain = press(""), hard = press(
                                      "inclusion.nodule = { centre = [0.018, 0.03, 0.02], radius = 0.012, "
                                      "young = 5e5 }");
  EXPECT_GT(hard, 1.3 * plain) << "N, of a hand that wants to be as deep";
}

TEST(HapticHand, a_model_that_answers_nan_gives_no_force_and_is_felt_again_when_it_answers) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.extrapolate(1.5);
    const double before = norm(hand.force());
    ASSERT_GT(before, 0.05) << model_of(world, tool);
    spoil(world, tool, kNan);
    hand.has_frames = tool != kTip;  // else the next frame would mend it
    hand.extrapolate(0.05);
    if (tool != kBall) {  // the limit that tissue bears gives none in place of NaN
      EXPECT_GT(hand.safety().counts.not_finite, 10u) << model_of(world, tool);
    }
    EXPECT_EQ(norm(hand.force()), 0) << model_of(world, tool);
    expect_harmless(hand, model_of(world, tool));
    if (tool == kTip) continue;  // its proxy is nowhere: see LocalTouch
    spoil(world, tool, 1);
    hand.extrapolate(1.5);
    EXPECT_NEAR(norm(hand.force()), before, 0.1 * before) << model_of(world, tool);
  }
}

TEST(HapticHand, a_model_that_answers_a_million_million_times_too_much_is_felt_as_the_limit_on_a_slope) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.extrapolate(1.5);
    double asked = 0;
    spoil(world, tool, 1e12);
    for (int n = 0; n < 800; n++) {
      hand.extrapolate(0.001, [&] { spoil(world, tool, 1e12); });
      asked = std::max(asked, norm(hand.asked()));
    }
    const std::string what = model_of(world, tool);
    // A chain bears 30 N itself, and what a lattice's frames leave is blended in, 20 N a second.
    EXPECT_GT(asked, tool == kFinger ? 1e9 : 10.0) << what << " [N]";
    EXPECT_GT(hand.largest, 0.9) << what << ": it is felt";
    expect_harmless(hand, what);
    if (tool == kTip) continue;
    EXPECT_GT(hand.safety().counts.slewed, 3u) << what;
  }
}

TEST(HapticHand, a_model_that_jumps_from_frame_to_frame_is_felt_as_slopes) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.extrapolate(1.5);
    int frame = 0;
    hand.extrapolate(0.5, [&] { spoil(world, tool, frame++ % 2 == 0 ? 300 : 1); });
    expect_harmless(hand, model_of(world, tool));
    if (tool == kTip) continue;  // what frames leave is blended in
    EXPECT_GT(hand.safety().counts.slewed, 10u) << model_of(world, tool);
  }
}

TEST(HapticHand, a_loop_that_stalls_while_it_presses_goes_on_without_a_jump) {
  for (const int tool : {kFinger, kBall, kTip}) {
    World world = pressed_world();
    HapticHand hand(world, tool);
    hand.extrapolate(0.3);  // on its way in
    for (int n = 0; n < 5; n++) hand.stall(0.1), hand.extrapolate(0.05);
    hand.extrapolate(0.5);
    EXPECT_GT(norm(hand.force()), 0.05) << model_of(world, tool);
    expect_harmless(hand, model_of(world, tool));
  }
}

TEST(HapticHand, physics_that_stands_still_becomes_damping_and_then_nothing) {
  World world = pressed_world();
  HapticHand hand(world, kTip);  // the others answer in the tick itself
  hand.extrapolate(1.5);
  ASSERT_GT(norm(hand.force()), 0.05);
  hand.has_frames = false;
  hand.extrapolate(1.5);
  EXPECT_GT(hand.reading.age, 1.0) << "s: known by who ticks";
  EXPECT_GT(hand.safety().counts.silent, 1000u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "lattice");
}

}  // namespace
}  // namespace turgor
