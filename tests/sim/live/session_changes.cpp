// Keys that a session changes while its world runs: wind, skin tension, modulus, friction.
#include <algorithm>
#include <string>

#include "tests/sim/live/session_scenes.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::four_kinds_file;
using test::fresh_folder;
using test::kOneThread;
using test::pad_file;
using test::wait_for_time;
using test::wait_for_world;
using test::wait_until;
using test::written;

/// Mean displacement along y of the 121 vertices of the first body, after another 0.5 s [m].
double mean_y(Session& session) {
  const double begin = session.now().snapshot.time;
  EXPECT_TRUE(
      wait_until(session, [begin](const SessionStatus& now) { return now.snapshot.time > begin + 0.5; }));
  double mean = 0;
  for (const Vec3 u : session.now().snapshot.bodies[0].displacement) mean += double(u.y) / 121;
  return mean;
}

// Wind moves a hanging cloth in the requested direction until the scene's wind changes.
TEST(SessionChanges, WindFollowsLatestRequest) {
  const fs::path file = written(fresh_folder(), "flag.toml", R"([world]
duration = 1
gravity = [0, 0, -9.81]
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0, 0.2], columns = 10, rows = 10 }
fabric = { law = "springs" }
solver = { method = "sweeps" }
[body.flag.hold.edge]
box = [[-0.01, -0.01, 0.19], [0.21, 0.01, 0.21]]
)");
  for (const double side : {-1.0, 1.0}) {
    Session session(file, {}, kOneThread);
    ASSERT_TRUE(wait_for_world(session)) << session.now().error;
    EXPECT_FALSE(session.now().is_haptic) << "no tool touches a cloth";
    session.request(WindRequest{.body = 0, .velocity = Vec3d{0, 6 * side, 0}});
    EXPECT_GT(side * mean_y(session), 0.02) << "m, along the wind";
    session.request(ChangeRequest{"body.flag.damping.motion", "0.8"});
    EXPECT_GT(side * mean_y(session), 0.02) << "another key keeps the requested wind";
    session.request(ChangeRequest{"body.flag.wind.velocity", side > 0 ? "[0, -6, 0]" : "[0, 6, 0]"});
    mean_y(session);
    EXPECT_LT(side * mean_y(session), -0.01) << "the scene's wind is the latest request";
  }
}

// A larger tension leaves intact skin at rest and opens a wound wider.
TEST(SessionChanges, TensionOpensWoundWider) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const fs::path file = written(folder, "block.toml", test::block_scene_text("block.nii"));
  const auto largest = [](const SessionStatus& now) {
    float most = 0;
    for (const Vec3 u : now.snapshot.bodies[0].displacement) most = std::max(most, norm(u));
    return double(most);
  };
  const auto settle = [](Session& session, double time) {
    return wait_until(session, [time](const SessionStatus& now) { return now.snapshot.time > time; });
  };
  Session whole(file, {"incision.cut.start=0.19"}, kOneThread);  // only near the end of the run
  ASSERT_TRUE(wait_for_world(whole)) << whole.now().error;
  whole.request(ChangeRequest{"body.block.skin.tension", "90"});
  ASSERT_TRUE(settle(whole, 0.15));
  EXPECT_LT(largest(whole.now()), 1e-5) << "m: the CT is the rest state";
  Session cut(file, {}, kOneThread);
  ASSERT_TRUE(wait_for_world(cut) && settle(cut, 1.5));
  const double before = largest(cut.now());
  EXPECT_GT(before, 5e-4);
  cut.request(ChangeRequest{"body.block.skin.tension", "90"});
  ASSERT_TRUE(settle(cut, 3.5));
  EXPECT_GT(largest(cut.now()), 1.4 * before);
}

Vec3d tool_force(const SessionStatus& now) { return now.snapshot.tools[0].force; }
/// Force on a finger that rests from a time [s] on: the first that stays over three times twenty ticks.
/// Without answers of a starved model it fades, and returns.
Vec3d resting_force(Session& session, double time) {
  Vec3d last, position;
  std::uint64_t ticks = 0;
  int repeated = 0;
  EXPECT_TRUE(wait_until(session, [&](const SessionStatus& now) {
    if (!(now.snapshot.time > time) || now.haptics.ticks < ticks + 20) return false;
    const Vec3d force = tool_force(now), tip = now.snapshot.tools[0].pose.position;
    const bool rests = tip == position && norm(force) > 0 && norm(force - last) <= 1e-7 * norm(force);
    repeated = rests ? repeated + 1 : 0;
    ticks = now.haptics.ticks, last = force, position = tip;
    return repeated >= 3;
  })) << norm(last);
  return last;
}
/// Force on a finger on its path at a time [s], after a changed key.
Vec3d force_at(const fs::path& file, double time, double change, const std::string& value) {
  Session session(file, {}, kOneThread);
  EXPECT_TRUE(wait_for_time(session, change)) << session.now().error;
  if (!value.empty()) session.request(ChangeRequest{"body.pad.young", value});
  const Vec3d force = resting_force(session, time);
  EXPECT_EQ(session.now().error, "");
  return force;
}

/// Mean ratio of tangential to normal force of a sliding finger over an interval of its path.
double friction_ratio(const fs::path& file, const std::string& friction) {
  Session session(file, {}, kOneThread);
  EXPECT_TRUE(wait_for_time(session, 0.4)) << session.now().error;
  if (!friction.empty()) session.request(ChangeRequest{"tool.finger.friction", friction});
  double sum = 0, last = 0;
  int count = 0;
  EXPECT_TRUE(wait_until(session, [&](const SessionStatus& now) {
    const double x = now.snapshot.tools[0].pose.position.x;
    if (x > 0.025 && x < 0.042 && x != last) sum -= tool_force(now).x / tool_force(now).z, count++;
    last = x;
    return x >= 0.042;
  }));
  EXPECT_EQ(session.now().error, "");
  return sum / std::max(count, 1);
}

// A changed modulus yields the force of a body that was built with it.
TEST(SessionChanges, ModulusChangeEqualsRebuild) {
  const std::string press =
      "path = [[0, 0.03, 0.03, 0.04], [0.3, 0.03, 0.03, 0.032], [9, 0.03, 0.03, 0.032]]";
  const Vec3d soft = force_at(pad_file(press), 0.9, 0.4, ""),
              changed = force_at(pad_file(press), 0.9, 0.4, "17e3"),
              made = force_at(pad_file(press, "17e3"), 0.9, 0.4, "");
  ASSERT_GT(soft.z, 0.05) << "N";
  EXPECT_LT(norm(changed - made), 1e-6 * norm(made));
  EXPECT_NEAR(norm(changed) / norm(soft), 3.4, 1e-6) << "ratio of stiffness";
}

// A changed friction during a slide yields the force of a tool that had it from the start.
TEST(SessionChanges, FrictionChangeEqualsRebuild) {
  const std::string slide =
      "path = [[0, 0.015, 0.03, 0.04], [0.3, 0.015, 0.03, 0.033], [1.5, 0.045, 0.03, 0.033]]\n"
      "interpolation = \"linear\"";
  const double little = friction_ratio(pad_file(slide), ""), more = friction_ratio(pad_file(slide), "0.8"),
               made = friction_ratio(pad_file(slide, "5e3", "0.8"), "");
  EXPECT_GT(made, 2 * little);
  EXPECT_NEAR(more, made, 0.05 * made) << "and " << little << " with 0.3";
}

// An invalid value is refused with the message of the scene reader.
TEST(SessionChanges, InvalidValueHasSceneMessage) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  session.request(ChangeRequest{"body.block.solver.sweeps", "-3"});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.error.empty(); }));
  EXPECT_NE(session.now().error.find("expected a whole number"), std::string::npos) << session.now().error;
}

}  // namespace
}  // namespace turgor
