// Haptic forces of a sheet under a press, and with wrong frames.
#include <limits>

#include "tests/sim/haptic_hand.hpp"

namespace turgor {
namespace {

using test::expect_harmless;
using test::HapticHand;

/// A sheet held on all sides; a ball presses it within half a second and stays.
World pressed_sheet(const std::string& rate) {
  const std::string text = R"(
[world]
gravity = [0, 0, -9.81]
duration = 4
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.15, 0, 0], up = [0, 0.1, 0], columns = 15, rows = 10 }
fabric = { law = "sheet", density = 0.3, warp = 300, weft = 300, shear = 60 }
solver = { method = "two_level" }
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

/// Multiplies the force of the next published plane.
void scale_force(World& world, double times) {
  ClothBody& sheet = world.cloth_bodies[0];
  contact::LocalContact plane{.is_near = true, .origin = sheet.poses[0].position, .normal = {0, 0, 1}};
  plane.force = plane.normal * (times * norm(sheet.forces[0].force));
  plane.stiffness = 100 * times, plane.friction = 0.3, plane.reach = 0.1;
  publish_contact(sheet, 0, plane);
}

// A hand settles on a sheet with physics at 100 Hz and at 30 Hz.
TEST(HapticCloth, HandSettlesOnSheet) {
  for (const char* rate : {"100", "30"}) {
    World world = pressed_sheet(rate);
    HapticHand hand(world, 0);
    hand.advance(2.0);
    EXPECT_GT(norm(hand.force()), 0.05) << rate << " Hz [N]";
    EXPECT_GT(dot(normalized(hand.force()), {0, 0, 1}), 0.95) << rate << " Hz: the tool is pushed back";
    double fastest = 0;
    for (int n = 0; n < 200; n++) hand.advance(0.001), fastest = std::max(fastest, hand.speed());
    EXPECT_LT(fastest, 0.002) << rate << " Hz: m/s, residual motion by encoder steps";
    expect_harmless(hand, rate);
  }
}

// The force on the hand equals the force of the holds within 10 percent.
TEST(HapticCloth, HandForceMatchesHolds) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.advance(3.0);
  const ClothBody& sheet = world.cloth_bodies[0];
  double holds = -sheet.model.total_mass * 9.81;
  for (const ClothHold& hold : sheet.holds) holds += hold.force.back().z;
  EXPECT_GT(holds, 0.05) << "N";
  EXPECT_NEAR(hand.force().z, holds, 0.1 * holds) << "N";
}

// Frames with NaN give no force.
TEST(HapticCloth, NanFramesGiveNoForce) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.advance(1.5);
  ASSERT_GT(norm(hand.force()), 0.05);
  scale_force(world, std::numeric_limits<double>::quiet_NaN());
  hand.has_frames = false;  // otherwise the next frame would overwrite it
  hand.advance(0.05);
  EXPECT_GT(hand.safety().counts.not_finite, 10u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "nan");
}

// Excessive and jumping forces are limited in magnitude and slope.
TEST(HapticCloth, ExcessiveForcesAreLimited) {
  for (const bool jumps : {false, true}) {
    World world = pressed_sheet("60");
    HapticHand hand(world, 0);
    hand.advance(1.5);
    const double before = norm(hand.force());
    double requested_force = 0;
    int frame = 0;
    for (int n = 0; n < 800; n++) {
      hand.advance(0.001, [&] { scale_force(world, jumps && frame++ % 2 == 0 ? 1 : 1e12); });
      requested_force = std::max(requested_force, norm(hand.requested_force()));
    }
    if (!jumps) {
      EXPECT_GT(requested_force, 10 * before) << "N: the hand receives the force until it is pushed away";
    }
    expect_harmless(hand, jumps ? "jumps" : "too much");
  }
}

// A stalled loop resumes without a jump, and the force fades when the physics stops.
TEST(HapticCloth, StallsCauseNoJump) {
  World world = pressed_sheet("60");
  HapticHand hand(world, 0);
  hand.advance(0.4);  // on the approach
  for (int n = 0; n < 5; n++) hand.stall(0.1), hand.advance(0.05);
  hand.advance(1.0);
  EXPECT_GT(norm(hand.force()), 0.05);
  expect_harmless(hand, "stall");
  hand.has_frames = false;
  hand.advance(1.5);
  EXPECT_GT(hand.safety().counts.silent, 1000u);
  EXPECT_EQ(norm(hand.force()), 0);
  expect_harmless(hand, "silence");
}

}  // namespace
}  // namespace turgor
