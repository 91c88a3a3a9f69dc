// What a hand is given by a sheet when it presses, and when the sheet's frames go wrong.
#include <limits>

#include "tests/sim/haptic_hand.hpp"

namespace turgor {
namespace {

using test::expect_harmless;
using test::HapticHand;

/// A sheet that is held all around; a ball presses it within half a second and stays.
World pressed_sheet(const std::string& rate) {
  const std::string text = R"(
[world]
gravity = [0, 0, -9.81]
duration = 4
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.15, 0, 0], up = [0, 0.1, 0], columns = 15, rows = 10 }
fabric = { law = "sheet", density = 0.3, warp = 300, weft = 300, shear = 60 }
solver = { method = "blocks" }
damping = { motion = 4 }
hold.left = { box = [[-1, -1, -1], [0.001, 1, 1]] }
hold.right = { box = [[0.149, -1, -1], [1, 1, 1]] }
hold.front = { box = [[-1, -1, -1], [1, 0.001, 1]] }
hold.back = { box = [[-1, 0.099, -1], [1, 1, 1]] }
[tool.ball]
body = "sheet"
shape = { sphere = 0.012 }
path = [[0, 0.08, 0.05, 0.02], [0.1, 0.08, 0.05, 0.02], [0.5, 0.08, 0.05, 0.002]]
)";
  const Result<Scene> scene = parse_scene(text, "sheet.toml", {"world.frame_rate=" + rate});
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// The next plane says so many times the force that the sheet has.
void spoil(World& world, double times) {
  ClothBody& sheet = world.cloth_bodies[0];
  contact::LocalContact plane{.is_near = true, .origin = sheet.poses[0].position, .normal = {0, 0, 1}};
  plane.force = plane.normal * (times * norm(sheet.forces[0].force));
  plane.stiffness = 100 * times, plane.friction = 0.3, plane.reach = 0.1;
  leave_plane(sheet, 0, plane);
}

TEST(FeltCloth, a_hand_comes_to_rest_on_a_sheet_with_physics_of_a_hundred_and_of_thirty_hertz) {
  for (const char* rate : {"100", "30"}) {
    World world = pressed_sheet(rate);
    HapticHand hand(world, 0);
    hand.extrapolate(2.0);
    EXPECT_GT(norm(hand.force()), 0.05) << rate << " Hz [N]";
    EXPECT_GT(dot(normalized(hand.force()), {0, 0, 1}), 0.95) << rate << " Hz: it is pushed back";
    double fastest = 0;
    for (int n = 0; n < 200; n++) hand.extrapolate(0.001), fastest = std::max(fastest, hand.speed());
    EXPECT_LT(fastest, 0.002) << rate << " Hz: m/s, what encoder steps alone may keep moving";
    expect_harmless(hand, rate);
  }
}

TEST(FeltCloth, what_a_hand_holds_is_what_the_holds_take_within_a_tenth) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.extrapolate(3.0);
  const ClothBody& sheet = world.cloth_bodies[0];
  double holds = -sheet.model.total_mass * 9.81;
  for (const ClothHold& hold : sheet.holds) holds += hold.force.back().z;
  EXPECT_GT(holds, 0.05) << "N";
  EXPECT_NEAR(hand.force().z, holds, 0.1 * holds) << "N";
}

TEST(FeltCloth, frames_that_answer_nan_give_no_force) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.extrapolate(1.5);
  ASSERT_GT(norm(hand.force()), 0.05);
  spoil(world, std::numeric_limits<double>::quiet_NaN());
  hand.has_frames = false;  // else the next frame would mend it
  hand.extrapolate(0.05);
  EXPECT_GT(hand.safety().counts.not_finite, 10u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "nan");
}

TEST(FeltCloth, frames_that_answer_far_too_much_or_jump_are_felt_as_the_limit_on_a_slope) {
  for (const bool jumps : {false, true}) {
    World world = pressed_sheet("60");
    HapticHand hand(world, 0);
    hand.extrapolate(1.5);
    const double before = norm(hand.force());
    double asked = 0;
    int frame = 0;
    for (int n = 0; n < 800; n++) {
      hand.extrapolate(0.001, [&] { spoil(world, jumps && frame++ % 2 == 0 ? 1 : 1e12); });
      asked = std::max(asked, norm(hand.asked()));
    }
    if (!jumps) {
      EXPECT_GT(asked, 10 * before) << "N: it is felt, until the hand is pushed away";
    }
    expect_harmless(hand, jumps ? "jumps" : "too much");
  }
}

TEST(FeltCloth, a_loop_that_stalls_goes_on_without_a_jump_and_physics_that_stands_still_becomes_nothing) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.extrapolate(0.4);  // on its way in
  for (int n = 0; n < 5; n++) hand.stall(0.1), hand.extrapolate(0.05);
  hand.extrapolate(1.0);
  EXPECT_GT(norm(hand.force()), 0.05);
  expect_harmless(hand, "stall");
  hand.has_frames = false;
  hand.extrapolate(1.5);
  EXPECT_GT(hand.safety().counts.silent, 1000u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "silence");
}

}  // namespace
}  // namespace turgor
