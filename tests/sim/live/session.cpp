#include "turgor/sim/live/session.hpp"

#include <chrono>
#include <fstream>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;
using test::kOneThread;
using test::wait_until;
using Phase = SessionStatus::Phase;

fs::path written(const fs::path& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder / name) << text;
  return folder / name;
}

/// A body of every model; no tool touches them before the mouse does.
fs::path four_kinds_file() {
  const fs::path folder = fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text = test::four_kinds_text(), no_cut = text.substr(0, text.find("[incision.cut]"));
  return written(folder, "four.toml", no_cut);
}

/// Waits until the world is ready and has this many frames.
bool wait_for_world(Session& session, int frames = 1) {
  return wait_until(session, [frames](const SessionStatus& now) {
    return now.phase == Phase::kReady && now.snapshot.frame >= frames;
  });
}

/// The highest point of a body, and a tool above it.
struct Above {
  Vec3d top;
  double tip = 0;  // height of the tool below its origin [m]
};
Above above(const SessionStatus& now, const MouseTool& mouse) {
  const ToolSnapshot& tool = now.snapshot.tools[std::size_t(mouse.tool)];
  const BodySnapshot& body = body_snapshot(now.snapshot, tool.body);
  Above target;
  target.top =
      Vec3d(*std::max_element(body.x.begin(), body.x.end(), [](Vec3 a, Vec3 b) { return a.z < b.z; }));
  for (const Vec3 x : tool.mesh.vertices) target.tip = std::max(target.tip, -double(x.z));
  return target;
}

/// The force on a tool that targets this depth, after 0.6 s [N].
double force_at(Session& session, std::size_t mouse, const Above& target, double depth, int teleports) {
  const MouseTool tool = session.now().mouse[mouse];
  const Vec3d high{0, 0, target.tip + 0.02}, wanted{0, 0, target.tip - depth};
  tool.device->set_target({.pose = {target.top + wanted, {}},
                           .hold = false,
                           .teleports = teleports,
                           .teleport_to = target.top + high});
  const double begin = session.now().snapshot.time;
  EXPECT_TRUE(
      wait_until(session, [begin](const SessionStatus& now) { return now.snapshot.time > begin + 0.6; }));
  const auto& haptic = session.now().haptic[std::size_t(tool.tool)];
  return haptic.empty() ? 0 : haptic.back().force;
}

// A mouse presses bodies of every model with contact, and the force of those that deform grows with the
// requested depth.
TEST(Session, MouseForceGrowsWithDepth) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  ASSERT_EQ(session.now().mouse.size(), 4u) << "sfem, rhombus, lattice, rigid";
  for (std::size_t mouse = 0; mouse < 3; mouse++) {
    const Above target = above(session.now(), session.now().mouse[mouse]);
    const double far = force_at(session, mouse, target, -0.02, 1),
                 near = force_at(session, mouse, target, 0.004, 1),
                 deep = force_at(session, mouse, target, 0.010, 1);
    EXPECT_EQ(far, 0) << "body " << mouse;
    EXPECT_GT(near, 0.005) << "body " << mouse;
    EXPECT_GT(deep, 1.5 * near) << "body " << mouse;
  }
}

// The session reports the progress of loading.
TEST(Session, ReportsLoadingProgress) {
  const std::string text =
      "[world]\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.1, 0.1, 0.06], count = [16, 16, 9] }\n"
      "fixed = \"bottom\"\ncache = false\n";
  double most = 0;
  Session session(written(fresh_folder(), "pad.toml", text), {}, kOneThread);
  ASSERT_TRUE(wait_until(
      session,
      [&most](const SessionStatus& now) {
        if (now.phase == Phase::kLoading && now.doing == "Green's functions") most = std::max(most, now.done);
        return now.phase == Phase::kReady;
      },
      60))
      << session.now().error;
  EXPECT_GT(most, 0);
  EXPECT_LE(most, 1);
}

// The world follows the clock at the requested pace, and the haptic loop keeps its rate.
TEST(Session, WorldFollowsRequestedPace) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 5)) << session.now().error;
  session.request(PaceRequest{.plays = true, .pace = 0.25});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.pace == 0.25; }));
  const double begin = session.now().snapshot.time;
  const auto deadlines = [&session] { return session.now().haptics.ticks + session.now().haptics.missed; };
  const std::uint64_t before = deadlines();
  const Timer timer;
  ASSERT_TRUE(
      wait_until(session, [begin](const SessionStatus& now) { return now.snapshot.time >= begin + 0.3; }));
  EXPECT_GE(timer.seconds(), 0.95 * 0.3 / 0.25);
  EXPECT_GT(deadlines(), before + 300) << "the haptic loop keeps its rate";
}

// A paused session stands still, and a step advances it by one frame.
TEST(Session, PausesAndSteps) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 3)) << session.now().error;
  session.request(PaceRequest{.plays = false, .pace = 1});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.plays; }));
  const int frame = session.now().snapshot.frame;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(session.now().snapshot.frame, frame);
  session.request(StepRequest{}), session.request(StepRequest{});
  EXPECT_TRUE(
      wait_until(session, [frame](const SessionStatus& now) { return now.snapshot.frame == frame + 2; }));
  session.request(PaceRequest{});
  EXPECT_TRUE(
      wait_until(session, [frame](const SessionStatus& now) { return now.snapshot.frame > frame + 4; }));
}

// A requested cut opens a wound, and a reset removes it.
TEST(Session, CutOpensWoundUntilReset) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const auto walls = [](const SessionStatus& now) {
    for (const BodySnapshot& body : now.snapshot.bodies)
      if (body.id.kind == BodyKind::kLattice) return body.triangles.size() - body.wall_begin;
    return std::size_t(0);
  };
  EXPECT_EQ(walls(session.now()), 0u);
  const int world = session.now().world;
  session.request(CutRequest{.blade = {.name = "cut",
                                       .from = {0.002, -0.02, -0.03},
                                       .to = {0.002, -0.02, 0.03},
                                       .depth = 0.012,
                                       .duration = 0.1},
                             .body = 0});
  EXPECT_TRUE(wait_until(session, [&](const SessionStatus& now) { return walls(now) > 50; }));
  ASSERT_EQ(session.now().cuts.size(), 1u);
  EXPECT_EQ(session.now().cuts[0].name, "block") << "named after the body";
  session.request(ResetRequest{});
  EXPECT_TRUE(wait_until(session, [&](const SessionStatus& now) {
    return now.phase == Phase::kReady && now.world > world && walls(now) == 0 && now.snapshot.frame < 20;
  }));
}

// A cut that misses the body is reported, and the world continues.
TEST(Session, CutOutsideBodyIsReported) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  session.request(
      CutRequest{.blade = {.name = "cut", .from = {1, 1, 1}, .to = {1, 1, 1.1}, .depth = 0.01}, .body = 0});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.error.empty(); }));
  EXPECT_NE(session.now().error.find("no cut"), std::string::npos);
  EXPECT_TRUE(session.now().cuts.empty()) << "no cut to save";
  const int frame = session.now().snapshot.frame;
  EXPECT_TRUE(
      wait_until(session, [frame](const SessionStatus& now) { return now.snapshot.frame > frame + 3; }));
}

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
TEST(Session, WindFollowsLatestRequest) {
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
TEST(Session, TensionOpensWoundWider) {
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

// The deformed CT of a resting body is computed once.
TEST(Session, CtOfRestingBodyIsCached) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const fs::path file = written(folder, "block.toml", test::block_scene_text("block.nii"));
  Session session(file, {"incision.cut.start=0.3", "world.duration=0.5"}, kOneThread);
  const auto request_ct_until = [&](const std::function<bool(const SessionStatus&)>& condition) {
    return wait_until(session, [&](const SessionStatus& now) {
      if (now.phase == Phase::kReady) session.request(CtRequest{});
      return now.ct && condition(now);
    });
  };
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  ASSERT_TRUE(request_ct_until([](const SessionStatus&) { return true; }));
  const std::shared_ptr<const DeformedCt> first = session.now().ct;
  ASSERT_TRUE(request_ct_until([](const SessionStatus& now) { return now.snapshot.time > 0.25; }));
  EXPECT_EQ(session.now().ct, first) << "frames continue, and nothing moves";
  ASSERT_TRUE(request_ct_until([&](const SessionStatus& now) { return now.snapshot.time > 0.35; }));
  EXPECT_NE(session.now().ct, first) << "after the cut";
  const int frame = session.now().ct->frame;
  ASSERT_TRUE(request_ct_until([&](const SessionStatus& now) { return now.ct->frame > frame + 5; }))
      << "the wound opens";
  EXPECT_EQ(session.now().ct->device.has_value(), false);
}

/// A pad with a finger on a path.
fs::path pad_file(const std::string& path, const std::string& young = "5e3", const std::string& mu = "0.3") {
  return written(fresh_folder(), "pad.toml", R"([world]
duration = 10
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
poisson = 0.4
precision = "double"
cache = false
young = )" + young + R"(
[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
friction = )" + mu + "\n" + path);
}
Vec3d tool_force(const SessionStatus& now) { return now.snapshot.tools[0].force; }
bool wait_for_time(Session& session, double time) {
  return wait_until(session, [time](const SessionStatus& now) { return now.snapshot.time > time; });
}
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
TEST(Session, ModulusChangeEqualsRebuild) {
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
TEST(Session, FrictionChangeEqualsRebuild) {
  const std::string slide =
      "path = [[0, 0.015, 0.03, 0.04], [0.3, 0.015, 0.03, 0.033], [1.5, 0.045, 0.03, 0.033]]\n"
      "interpolation = \"linear\"";
  const double little = friction_ratio(pad_file(slide), ""), more = friction_ratio(pad_file(slide), "0.8"),
               made = friction_ratio(pad_file(slide, "5e3", "0.8"), "");
  EXPECT_GT(made, 2 * little);
  EXPECT_NEAR(more, made, 0.05 * made) << "and " << little << " with 0.3";
}

// An elastic body returns the work of a press when the tool leaves.
TEST(Session, ElasticBodyReturnsWork) {
  const std::string press =
      "path = [[0, 0.03, 0.03, 0.04], [0.4, 0.03, 0.03, 0.031], [0.6, 0.03, 0.03, 0.031], [1, 0.03, 0.03, "
      "0.04], [9, 0.03, 0.03, 0.04]]";
  Session session(pad_file(press, "5e3", "0"), {}, kOneThread);
  ASSERT_TRUE(wait_for_time(session, 1.1)) << session.now().error;
  HapticSample most, before;
  double area = 0;  // integral of force over depth during loading [J]
  for (const HapticSample& point : session.now().haptic[0]) {
    if (point.depth > before.depth) area += 0.5 * (point.force + before.force) * (point.depth - before.depth);
    before = point;
    if (point.work > most.work) most = point;
  }
  EXPECT_GT(most.force, 0.05) << "N";
  EXPECT_NEAR(most.work, area, 0.05 * area) << "integral over frames; the work is summed over ticks";
  EXPECT_LT(most.work, 0.5 * most.force * most.depth) << "the contact of a ball stiffens with depth";
  EXPECT_NEAR(session.now().haptic[0].back().work, 0, 0.02 * most.work) << "J";
}

// A reload reads the file that failed.
TEST(Session, ReloadReadsFailedFile) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const fs::path folder = fresh_folder(), bad = written(folder, "pad.toml", "[world]\nduration = -1\n");
  session.request(OpenRequest{.file = bad, .overrides = {}});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.phase == Phase::kFailed; }));
  fs::copy_file(pad_file("path = [[0, 0.03, 0.03, 0.04]]"), bad, fs::copy_options::overwrite_existing);
  session.request(ReloadRequest{});
  EXPECT_TRUE(wait_until(session, [](const SessionStatus& now) {
    return now.phase == Phase::kReady && now.snapshot.bodies.size() == 1 &&
           now.snapshot.bodies[0].name == "pad";
  }));
}

// An invalid value is refused with the message of the scene reader.
TEST(Session, InvalidValueHasSceneMessage) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  session.request(ChangeRequest{"body.block.solver.sweeps", "-3"});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.error.empty(); }));
  EXPECT_NE(session.now().error.find("expected a whole number"), std::string::npos) << session.now().error;
}

// A wrong scene is reported, and another one can be opened after it.
TEST(Session, OpensSceneAfterError) {
  const fs::path bad = written(fresh_folder(), "bad.toml", "[world]\nduration = -1\n");
  Session session(bad, {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.phase == Phase::kFailed; }));
  EXPECT_NE(session.now().error.find("bad.toml:2"), std::string::npos) << session.now().error;
  session.request(ResetRequest{});  // the same error again, not a crash
  session.request(OpenRequest{.file = four_kinds_file(), .overrides = {}});
  EXPECT_TRUE(wait_for_world(session)) << session.now().error;
}

// A reset reads the corrected file, even if another scene was open before.
TEST(Session, ResetReadsCorrectedFile) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const fs::path bad = written(fresh_folder(), "bad.toml", "[world]\nduration = -1\n");
  session.request(OpenRequest{.file = bad, .overrides = {}});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.phase == Phase::kFailed; }));
  EXPECT_EQ(session.now().scene, nullptr) << "the previous scene is not of this file";
  fs::copy_file(four_kinds_file(), bad, fs::copy_options::overwrite_existing);
  session.request(ResetRequest{});
  EXPECT_TRUE(
      wait_until(session, [&](const SessionStatus& now) { return now.scene && now.scene->file == bad; }));
}

// A single step with non-finite values is reported.
TEST(Session, SingleNonFiniteStepIsReported) {
  const fs::path file = written(fresh_folder(), "stiff.toml", R"([world]
duration = 0.5
frame_rate = 20
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 1], side = [1.5, 0, 0], up = [0, 0, 1], columns = 10, rows = 8 }
fabric = { law = "springs", density = 0.12, warp = 1e30, weft = 800, shear = 150, bend = 2 }
solver = { method = "sweeps" }
wind = { velocity = [100, 0, 0] }
)");
  Session session(file, {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.error.empty() && !now.plays; }));
  const auto is_reported = [](const SessionStatus& now) {
    return now.error.find("not finite") != std::string::npos;
  };
  EXPECT_TRUE(is_reported(session.now())) << session.now().error;
  EXPECT_EQ(session.now().error.find("skin tension"), std::string::npos) << "the scene has no skin";
  session.request(ChangeRequest{"body.flag.wind.velocity", "[100, 0, 0]"});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.error.empty(); }));
  session.request(StepRequest{});
  EXPECT_TRUE(wait_until(session, is_reported));
}

// A reader that does not call for a second delays neither ticks nor frames.
TEST(Session, IdleReaderCostsNoTicks) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 5)) << session.now().error;
  const SessionStatus& now = session.now();
  const int begin = now.snapshot.frame;
  const haptics::TimingReport before = now.haptics;
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const SessionStatus& after = session.now();
  EXPECT_GT(after.snapshot.frame, begin + 3) << "frames continued";
  EXPECT_GT(after.haptics.ticks + after.haptics.missed, before.ticks + before.missed + 700);
  EXPECT_LT(after.haptics.period.largest, 0.95) << "s: no pause as long as the reader's";
}

}  // namespace
}  // namespace turgor
