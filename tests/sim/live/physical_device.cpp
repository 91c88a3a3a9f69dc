// Axes of a tool in a physical device or in a replayed hand, and the limits of the device that a scene names.
#include <cmath>

#include <fmt/format.h>

#include "tests/folders.hpp"
#include "tests/haptics/drivers/fake_library.hpp"
#include "tests/haptics/fakes/fake_drd.hpp"
#include "turgor/sim/live/live_run.hpp"

namespace turgor {
namespace {

/// A block of 6 cm on its back side, and a tool that presses it.
World pressed_block(const std::string& tool, double young = 1e4) {
  const std::string text = fmt::format(
      "[world]\nduration = 5\nframe_rate = 50\n[body.block]\nmodel = \"sfem\"\nblock = {{ size = [0.06, "
      "0.06, "
      "0.06], count = [4, 4, 4] }}\nfixed = \"back\"\nyoung = {}\ncache = false\n[tool.one]\nbody = "
      "\"block\"\n{}\n",
      young, tool);
  const Result<Scene> scene = parse_scene(text, test::fresh_folder() / "block.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

const char* const kNeedle = "shape = { needle = 0.06, diameter = 0.001 }";
/// Presses from the front, whose outward normal is −y, and from the top.
const char* const kFromFront = "press = { at = [0.031, 0, 0.028], depth = 0.01, start = 4 }";
const char* const kFromTop = "press = { at = [0.031, 0.028, 0.06], depth = 0.01, start = 4 }";

/// Runs frames of 20 ms with the tool in the device. Returns the run, whose tools have their logs.
Result<LiveRun> run_with(World& world, const LiveOptions& options, int frames) {
  Result<LiveRun> live = start_live(world, options, 5);
  if (!live) return live;
  for (int frame = 0; frame < frames; frame++) {
    EXPECT_TRUE(step(Exec(1), world));
    live->touch->wait_for_frame();
  }
  live->touch->stop();
  return live;
}

LiveOptions with_arm() { return {.device = "dhd", .driver = {.library = FAKE_DRD}}; }

FakeDrd& fresh_arm() {
  FakeDrd& arm = *test::fake<FakeDrd>(FAKE_DRD, "fake_drd");
  return arm = {};
}

/// Direction of the tool's z axis after some ticks.
Vec3d shaft_of(const std::string& press, const LiveOptions& options) {
  World world = pressed_block(kNeedle + std::string("\n") + press);
  const Result<LiveRun> live = run_with(world, options, 3);
  EXPECT_TRUE(live) << live.error().message;
  EXPECT_FALSE(world.tools[0].samples.empty());
  return world.tools[0].samples.back().axes.column[2];
}

// A needle in an arm without a wrist keeps the direction of its press: its shaft is along the outward normal.
TEST(PhysicalDevice, NeedleWithoutWristKeepsDirection) {
  fresh_arm();
  EXPECT_LT(norm(shaft_of(kFromFront, with_arm()) - Vec3d{0, -1, 0}), 1e-9);
  EXPECT_LT(norm(shaft_of(kFromTop, with_arm()) - Vec3d{0, 0, 1}), 1e-9);
}

// The tip of a needle in an arm with a wrist points where the tip of the grip points.
TEST(PhysicalDevice, NeedlePointsWhereGripPoints) {
  FakeDrd& arm = fresh_arm();
  arm.type = 34, arm.has_wrist = true;  // omega.6
  // at rest the tip of the grip points away from the user: into the front of the body
  EXPECT_LT(norm(shaft_of(kFromTop, with_arm()) - Vec3d{0, -1, 0}), 1e-9);
  // a quarter turn about x, to the right: the tip points up, and the shaft down. The arm's y is to the right.
  const double turned[3][3] = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}};
  for (int i = 0; i < 3; i++) std::copy_n(turned[i], 3, arm.frame[i]);
  EXPECT_LT(norm(shaft_of(kFromTop, with_arm()) - Vec3d{0, 0, -1}), 1e-9);
}

// A replayed hand turns the tool only if its file has orientations.
TEST(PhysicalDevice, ReplayTurnsToolByItsQuaternions) {
  const std::filesystem::path file = test::fresh_folder() / "poses.csv";
  const LiveOptions options{.device = "replay", .driver = {.file = file}};
  test::write(file, "time_s,x_m,y_m,z_m\n0,0,0,0\n");
  EXPECT_LT(norm(shaft_of(kFromTop, options) - Vec3d{0, 0, 1}), 1e-9);
  test::write(file, "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n");
  EXPECT_LT(norm(shaft_of(kFromTop, options) - Vec3d{0, -1, 0}), 1e-9);
}

// A hand with a delta.3 presses a stiff block. With the device that the scene names, the arm renders more
// than the usual limit of 10 N, and the spring of the virtual coupling, 5000 N/m, between hand and tool.
TEST(PhysicalDevice, NamedDeviceLimitsForceAndStiffness) {
  FakeDrd& arm = fresh_arm();
  arm.type = 63;                                                 // delta.3
  arm.readings_at_rest = 1300, arm.readings_of_approach = 1000;  // the soft start takes a second
  arm.approach[2] = -7.4e-6;                                     // [m] a reading of a millisecond
  World world = pressed_block(
      "shape = { sphere = 0.012 }\npress = { at = [0.031, 0.028, 0.06], depth = 0.001, start = 4 }", 1e6);
  LiveOptions options = with_arm();
  options.limits = "delta.3";
  const double height = command_at(world.tools[0], 0).pose.position.z;
  Result<LiveRun> live = run_with(world, options, 130);
  ASSERT_TRUE(live) << live.error().message;
  EXPECT_TRUE(live->notes.empty());
  const ForceSample& last = world.tools[0].samples.back();
  EXPECT_GT(last.force.z, 12) << "N";
  EXPECT_LT(last.force.z, 20) << "N";
  EXPECT_NEAR(arm.largest_force, last.force.z, 0.3) << "N";
  EXPECT_NEAR(5000 * (last.position.z - (height + arm.position[2])), last.force.z, 0.3) << "N";
}

// A device with other limits than the named one: the smaller ones apply, and a note says so.
TEST(PhysicalDevice, OtherDeviceThanNamedIsNoted) {
  fresh_arm().type = 33;  // omega.3
  World world = pressed_block(std::string(kNeedle) + "\n" + kFromFront);
  LiveOptions options = with_arm();
  options.limits = "touch";
  Result<LiveRun> live = run_with(world, options, 2);
  ASSERT_TRUE(live) << live.error().message;
  const Json notes = haptics_report(*live).at("notes");
  EXPECT_NE(
      notes.dump().find("names a 3D Systems Touch (3.3 N, 400 N/m), and the device is a fake arm (12 N, "
                        "5000 N/m): the smaller limits apply"),
      std::string::npos)
      << notes.dump();
}

}  // namespace
}  // namespace turgor
