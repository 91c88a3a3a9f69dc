#include "turgor/sim/live/session.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/sim/live/session_scenes.hpp"
#include "turgor/core/timing.hpp"

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
using Phase = SessionStatus::Phase;

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
