#include "turgor/sim/tools/hand.hpp"

#include <gtest/gtest.h>

#include "tests/refused.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/report/forces_csv.hpp"
#include "turgor/sim/report/report_rhombus.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

World run_world(const std::string& text, const std::filesystem::path& folder,
                const std::vector<std::string>& overrides = {}) {
  const Scene scene = *parse_scene(text, folder / "scene.toml", overrides);
  Result<World> world = load_world(Exec(1), scene);
  EXPECT_TRUE(world) << world.error().message;
  for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(Exec(1), *world));
  return std::move(*world);
}

/// Runs a scene, and the same scene with its force table as the motion of its tools.
void expect_same_bits(const std::string& body, const std::string& tools,
                      const std::vector<std::string>& motions) {
  const auto folder = test::fresh_folder();
  const World first = run_world(body + tools, folder);
  ASSERT_TRUE(write_forces(folder / "forces.csv", first.tools));
  std::string replayed = tools;
  for (const std::string& motion : motions) {
    ASSERT_NE(replayed.find(motion), std::string::npos);
    replayed.replace(replayed.find(motion), motion.size(), "hand = \"forces.csv\"");
  }
  const World second = run_world(body + replayed, folder);
  for (std::size_t t = 0; t < first.tools.size(); t++) {
    const TouchLog &a = first.tools[t].samples, &b = second.tools[t].samples;
    ASSERT_EQ(a.size(), b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); i++) {
      ASSERT_EQ(a[i].force, b[i].force) << a[i].time;
      ASSERT_EQ(a[i].torque, b[i].torque) << a[i].time;
      ASSERT_EQ(a[i].grip, b[i].grip) << a[i].time;
      largest = std::max(largest, norm(a[i].force));
    }
    EXPECT_GT(largest, 1e-3) << "N: the tool is in contact";
  }
  EXPECT_EQ(state_hash(first), state_hash(second));
}

// A tool on an SFEM body that replays the force table of a run has the same bits.
TEST(Hand, SfemReplaysForceTable) {
  const std::string press =
      "press = { at_fraction = [0.3, 0.5, 1], to_fraction = [0.7, 0.4, 1], depth = 0.003, start = 0, "
      "duration = "
      "0.1, hold = 0.05, slide = 0.15 }";
  const std::string held =
      "path = [[0, 0.04, 0.03, 0.04], [0.1, 0.041, 0.033, 0.032, 1, 0.9, 0.1, 0.2, 0.3], [0.2, 0.044, 0.03, "
      "0.036, 1, 0.7, 0.3, 0.2, 0.1], [0.25, 0.044, 0.03, 0.05]]";
  expect_same_bits(
      "[world]\nduration = 0.35\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count = "
      "[8, "
      "8, 4] }\nfixed = \"bottom\"\nyoung = 5e3\npoisson = 0.4\ncache = false\nrotations = true\n",
      "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n" + press +
          "\n[tool.rod]\nbody = \"pad\"\nshape = { capsule = [0.004, 0.006] }\n" + held + "\n",
      {press, held});
}

// Forceps on a rhombus body that replay the force table of a run have the same bits.
TEST(Hand, RhombusReplaysForceTable) {
  const std::string grasp =
      "grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.006, pull = 0.012, aside = [0.003, 0.002, 0], "
      "duration = "
      "0.2, hold = 0.35 }";
  const std::string press = "press = { at_fraction = [0.6, 0.5, 1], depth = 0.004, duration = 0.2 }";
  expect_same_bits(
      "[world]\nduration = 1.7\n[body.liver]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\nbulge "
      "= 0.4\n",
      "[tool.forceps]\nbody = \"liver\"\nshape = { forceps = \"phantom\" }\n" + grasp +
          "\n[tool.ball]\nbody = \"liver\"\nshape = { sphere = 0.005 }\n" + press + "\n",
      {grasp, press});
}

// A table requires only columns for time and position.
TEST(Hand, TableRequiresTimeAndPositionOnly) {
  const auto folder = test::fresh_folder();
  ASSERT_TRUE(write_file(folder / "h.csv",
                         "z_m, time_s,note ,x_m,y_m,grip\n0.1,0,up,1,2,0\n\n0.2,0.5,down,3,4,0.25\n"));
  const std::vector<HandRow> hand = *read_hand(folder / "h.csv", "any");
  ASSERT_EQ(hand.size(), 2u);
  EXPECT_EQ(hand[1].command.pose.position, (Vec3d{3, 4, 0.2}));
  EXPECT_EQ(hand[1].command.pose.axes, Mat3d{});
  EXPECT_EQ(hand[1].command.grip, 0.25);
  EXPECT_EQ(hand_at(hand, -1).command.pose.position.x, 1);
  EXPECT_EQ(hand_at(hand, 0.4999).command.pose.position.x, 1) << "the newest row holds until the next one";
  EXPECT_EQ(hand_at(hand, 0.5).command.pose.position.x, 3);
}

// A hand converted to a path has the same axes.
TEST(Hand, PathKeepsAxes) {
  std::vector<HandRow> hand;
  for (const std::array<double, 4> q : {std::array{1.0, 0.0, 0.0, 0.0},
                                        {0.0, 1.0, 0.0, 0.0},
                                        {0.0, 0.0, 0.6, 0.8},
                                        {0.5, -0.5, 0.5, 0.5},
                                        {0.1, 0.7, -0.7, 0.1},
                                        {-0.8, 0.6, 0.0, 0.0}})
    hand.push_back({double(hand.size()), {.pose = {{}, axes_of(q)}}});
  const ToolPath path = path_of(hand);
  for (std::size_t r = 0; r < hand.size(); r++) {
    const Mat3d axes = axes_of(path.rows[r].orientation);
    for (int a = 0; a < 3; a++)
      EXPECT_LT(norm(axes.column[a] - hand[r].command.pose.axes.column[a]), 1e-14) << r;
  }
}

// Invalid tables are refused with their line number.
TEST(Hand, RejectsInvalidTables) {
  const auto folder = test::fresh_folder();
  const auto read = [&](const std::string& text) {
    EXPECT_TRUE(write_file(folder / "h.csv", text));
    return read_hand(folder / "h.csv", "finger");
  };
  const std::string names = "tool,time_s,x_m,y_m,z_m,grip\n";
  EXPECT_REFUSED(read("0,1,2,3\n"), "h.csv:1: expected a first line with column names, among them time_s",
                 "");
  EXPECT_REFUSED(read(names + "finger,0,1,2,x,0\n"), "h.csv:2: expected a number for z_m, found \"x\"", "");
  EXPECT_REFUSED(read(names + "finger,0,1,2\n"), "h.csv:2: expected a number for z_m", "");
  EXPECT_REFUSED(read(names + "finger,1,1,2,3,0\nfinger,1,1,2,3,0\n"), "h.csv:3: expected a time after",
                 "1 s");
  EXPECT_REFUSED(read(names + "finger,0,1,2,3,1.5\n"), "h.csv:2: expected a grip from 0 (open) to 1", "1.5");
  EXPECT_REFUSED(read(names + "rod,0,1,2,3,0\n"), "expected rows of the tool finger, found those of rod", "");
  EXPECT_REFUSED(read(names), "expected a row per tick, found none", "");
  EXPECT_REFUSED(read("time_s,x_m,y_m,z_m,axis_x_x\n"), "expected all of axis_x_x", "1 of the nine");
  EXPECT_REFUSED(
      read("time_s,x_m,y_m,z_m,axis_x_x,axis_x_y,axis_x_z,axis_y_x,axis_y_y,axis_y_z,axis_z_x,axis_z_y,"
           "axis_z_z\n0,0,0,0,1,0,0,0,1,0,0,0,-1\n"),
      "h.csv:2: expected orthonormal right-handed axes", "");
  EXPECT_FALSE(read_hand(folder / "absent.csv", "finger"));
}

// A full log counts the samples that it cannot store.
TEST(Hand, FullLogCountsMissedSamples) {
  TouchLog log;
  log.preallocate(3);
  for (int i = 0; i < 5; i++) log.append({.time = 1e-3 * i, .position = {0.1 * i, 0, 0}});
  EXPECT_EQ(log.size(), 3u);
  EXPECT_EQ(log.missed(), 2u);
  EXPECT_NEAR(log.back().path, 0.2, 1e-15);
  World world;
  world.tools.push_back({.name = "finger", .body = {BodyKind::kSfem, 0}});
  world.tools[0].samples = log;
  world.sfem_bodies.emplace_back();
  bool reported = false;
  for (const std::string& warning : touch_warnings(world))
    reported = reported || warning.find("finger: its log holds the first 3 ms and lacks the last 2 ms") == 0;
  EXPECT_TRUE(reported);
}

}  // namespace
}  // namespace turgor
