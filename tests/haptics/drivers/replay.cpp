#include "turgor/haptics/drivers/replay.hpp"

#include <numbers>
#include <thread>

#include "tests/folders.hpp"
#include "tests/refused.hpp"

namespace turgor::haptics {
namespace {

namespace fs = std::filesystem;

Result<std::vector<PoseRow>> read(const std::string& text) {
  const fs::path file = test::fresh_folder() / "hand.csv";
  test::write(file, text);
  return read_poses(file);
}

// Columns may have any order, and comments may separate rows.
TEST(Replay, ColumnsHaveAnyOrder) {
  const auto rows =
      read("# a hand\nbuttons; z_m; time_s; x_m; y_m\n3; 0.01; 0; 0.02; 0.03\n\n# later\n0; 0; 1.5; 0; 0\n");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0].position, (Vec3d{0.02, 0.03, 0.01}));
  EXPECT_EQ((*rows)[0].buttons, 3u);
  EXPECT_EQ((*rows)[1].time, 1.5);
}

// Position and rotation are interpolated linearly between two rows.
TEST(Replay, PosesAreInterpolated) {
  // A quarter turn about z and 40 mm along x, in half a second.
  const auto rows = read(
      "time_s,x_m,y_m,z_m,qw,qx,qy,qz,grip,buttons\n1,0,0,0,1,0,0,0,0,1\n1.5,0.04,0,0,0.70710678,0,0,0."
      "70710678,1,2\n");
  ASSERT_TRUE(rows) << rows.error().message;
  const DeviceInput half = pose_at(*rows, 1.25);
  const double angle = std::numbers::pi / 4;
  EXPECT_NEAR(half.pose.position.x, 0.02, 1e-12);
  EXPECT_NEAR(norm(half.pose.axes.column[0] - Vec3d{std::cos(angle), std::sin(angle), 0}), 0, 1e-9);
  EXPECT_NEAR(half.velocity.x, 0.08, 1e-12);
  EXPECT_NEAR(half.angular_velocity.z, std::numbers::pi, 1e-7);  // a quarter turn in half a second
  EXPECT_NEAR(half.grip, 0.5, 1e-12);
  EXPECT_EQ(half.buttons, 1u);
  for (const double outside : {0.0, 9.0}) EXPECT_EQ(norm(pose_at(*rows, outside).velocity), 0) << outside;
  EXPECT_NEAR(pose_at(*rows, 9).pose.position.x, 0.04, 1e-12);
}

// An error in the file is reported with its line and the value that was found.
TEST(Replay, BadLineIsLocated) {
  const std::string head = "time_s,x_m,y_m,z_m\n";
  EXPECT_REFUSED(read(head + "0,0,0,0\n1,0,zero,0\n"), "hand.csv:3", "1,0,zero,0");
  EXPECT_REFUSED(read(head + "0,0,0\n"), "hand.csv:2", "expected 4 numbers", "found 3");
  EXPECT_REFUSED(read(head + "0,0,0,0\n0,0,0,0\n"), "hand.csv:3", "after 0 s", "found 0 s");
  EXPECT_REFUSED(read(head + "0,120,0,0\n"), "hand.csv:2", "in meters", "120");
  EXPECT_REFUSED(read(head + "0,nan,0,0\n"), "hand.csv:2");
  EXPECT_REFUSED(read(head), "hand.csv", "found none");
  EXPECT_REFUSED(read("0,0,0,0\n"), "hand.csv", "time_s is missing");
  EXPECT_REFUSED(read("time_s,x_mm,y_m,z_m\n0,0,0,0\n"), "x_m, y_m", "found \"x_mm\"");
  EXPECT_REFUSED(read("time_s,x_m,x_m,y_m,z_m\n0,0,0,0,0\n"), "x_m is given twice");
  EXPECT_REFUSED(read("time_s,x_m,y_m,z_m,qw\n0,0,0,0,1\n"), "all of qw, qx, qy, qz");
  EXPECT_REFUSED(read("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n"), "hand.csv:2", "length 1",
                 "length 0");
  EXPECT_REFUSED(read("time_s,x_m,y_m,z_m,grip\n0,0,0,0,2\n"), "hand.csv:2", "from 0 to 1", "found 2");
  EXPECT_REFUSED(read("time_s,x_m,y_m,z_m,buttons\n0,0,0,0,1.5\n"), "hand.csv:2", "whole number", "1.5");
  EXPECT_REFUSED(read_poses("/nowhere/hand.csv"), "/nowhere/hand.csv");
}

// Time starts at the first exchange, and forces are not limited.
TEST(Replay, TimeStartsAtFirstExchange) {
  const fs::path file = test::fresh_folder() / "hand.csv";
  test::write(file, "time_s,x_m,y_m,z_m\n5,0,0,0\n5.1,0.1,-0.05,0\n");
  Result<std::unique_ptr<Device>> device = open_device("replay", {.file = file});
  ASSERT_TRUE(device) << device.error().message;
  const DeviceSpec& spec = (*device)->spec();
  EXPECT_EQ(spec.workspace_low, (Vec3d{0, -0.05, 0}));
  EXPECT_EQ(spec.workspace_high, (Vec3d{0.1, 0, 0}));
  EXPECT_EQ(within_limits(spec, {.force = {1e6, 0, 0}}).force.x, 1e6);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  DeviceInput input;
  ASSERT_TRUE((*device)->exchange({}, input));
  EXPECT_EQ(input.pose.position.x, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  ASSERT_TRUE((*device)->exchange({}, input));
  EXPECT_EQ(input.pose.position.x, 0.1);
  (*device)->close();
  EXPECT_FALSE((*device)->exchange({}, input));
  EXPECT_NE((*device)->trouble(), "");
}

// Without a file the error states that a file of poses is expected.
TEST(Replay, MissingFileOptionIsExplained) { EXPECT_REFUSED(open_device("replay"), "file of poses"); }

}  // namespace
}  // namespace turgor::haptics
