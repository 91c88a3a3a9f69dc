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
using Phase = SessionNow::Phase;

fs::path written(const fs::path& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder / name) << text;
  return folder / name;
}

/// A body of every model, none of which is touched before the mouse does.
fs::path four_kinds_file() {
  const fs::path folder = fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text = test::four_kinds_text(), no_cut = text.substr(0, text.find("[incision.cut]"));
  return written(folder, "four.toml", no_cut);
}

/// Looks until it is so, at most so long [s].
bool wait_for_world(Session& session, int frames = 1) {
  return wait_until(session, [frames](const SessionNow& now) {
    return now.phase == Phase::kReady && now.snapshot.frame >= frames;
  });
}

/// Straight above the highest place of a body.
struct Above {
  Vec3d top;
  double tip = 0;  // of the tool below its origin [m]
};
Above above(const SessionNow& now, const MouseTool& mouse) {
  const ToolSnapshot& tool = now.snapshot.tools[std::size_t(mouse.tool)];
  const BodySnapshot& body = body_snapshot(now.snapshot, tool.body);
  Above place;
  place.top =
      Vec3d(*std::max_element(body.x.begin(), body.x.end(), [](Vec3 a, Vec3 b) { return a.z < b.z; }));
  for (const Vec3 x : tool.mesh.vertices) place.tip = std::max(place.tip, -double(x.z));
  return place;
}

/// The force after a while under a tool that wants to be so deep [N].
double force_at(Session& session, std::size_t mouse, const Above& place, double depth, int put) {
  const MouseTool tool = session.now().mouse[mouse];
  const Vec3d high{0, 0, place.tip + 0.02}, wanted{0, 0, place.tip - depth};
  tool.device->lead(
      {.pose = {place.top + wanted, {}}, .hold = false, .put = put, .put_at = place.top + high});
  const double begin = session.now().snapshot.time;
  EXPECT_TRUE(
      wait_until(session, [begin](const SessionNow& now) { return now.snapshot.time > begin + 0.6; }));
  const auto& haptic = session.now().haptic[std::size_t(tool.tool)];
  return haptic.empty() ? 0 : haptic.back().force;
}

TEST(Session,
     a_mouse_presses_bodies_of_every_model_that_is_touched_and_feels_more_the_deeper_it_wants_to_be) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  ASSERT_EQ(session.now().mouse.size(), 3u) << "sfem, rhombus, lattice";
  for (std::size_t mouse = 0; mouse < 3; mouse++) {
    const Above place = above(session.now(), session.now().mouse[mouse]);
    const double far = force_at(session, mouse, place, -0.02, 1),
                 near = force_at(session, mouse, place, 0.004, 1),
                 deep = force_at(session, mouse, place, 0.010, 1);
    EXPECT_EQ(far, 0) << "body " << mouse;
    EXPECT_GT(near, 0.005) << "body " << mouse;
    EXPECT_GT(deep, 1.5 * near) << "body " << mouse;
  }
}

TEST(Session, who_looks_on_is_told_how_far_loading_is) {
  const std::string text =
      "[world]\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.1, 0.1, 0.06], count = [16, 16, 9] }\n"
      "fixed = \"bottom\"\ncache = false\n";
  double most = 0;
  Session session(written(fresh_folder(), "pad.toml", text), {}, kOneThread);
  ASSERT_TRUE(wait_until(
      session,
      [&most](const SessionNow& now) {
        if (now.phase == Phase::kLoading && now.doing == "Green's functions") most = std::max(most, now.done);
        return now.phase == Phase::kReady;
      },
      60))
      << session.now().error;
  EXPECT_GT(most, 0);
  EXPECT_LE(most, 1);
}

TEST(Session, a_world_goes_on_by_the_clock_at_the_pace_that_is_asked_for) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 5)) << session.now().error;
  session.request(PaceRequest{.plays = true, .pace = 0.25});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return now.pace == 0.25; }));
  const double begin = session.now().snapshot.time;
  const std::uint64_t ticks = session.now().haptics.ticks;
  const Timer timer;
  ASSERT_TRUE(
      wait_until(session, [begin](const SessionNow& now) { return now.snapshot.time >= begin + 0.3; }));
  EXPECT_GE(timer.seconds(), 0.95 * 0.3 / 0.25);
  EXPECT_GT(session.now().haptics.ticks, ticks + 300) << "the loop keeps its own rate";
}

TEST(Session, it_stands_still_when_asked_and_a_step_is_one_frame) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 3)) << session.now().error;
  session.request(PaceRequest{.plays = false, .pace = 1});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return !now.plays; }));
  const int frame = session.now().snapshot.frame;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(session.now().snapshot.frame, frame);
  session.request(StepRequest{}), session.request(StepRequest{});
  EXPECT_TRUE(
      wait_until(session, [frame](const SessionNow& now) { return now.snapshot.frame == frame + 2; }));
  session.request(PaceRequest{});
  EXPECT_TRUE(wait_until(session, [frame](const SessionNow& now) { return now.snapshot.frame > frame + 4; }));
}

TEST(Session, a_cut_that_is_asked_for_opens_a_wound_and_a_reset_closes_it) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const auto walls = [](const SessionNow& now) {
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
  EXPECT_TRUE(wait_until(session, [&](const SessionNow& now) { return walls(now) > 50; }));
  ASSERT_EQ(session.now().cuts.size(), 1u);
  EXPECT_EQ(session.now().cuts[0].name, "block") << "the body's";
  session.request(ResetRequest{});
  EXPECT_TRUE(wait_until(session, [&](const SessionNow& now) {
    return now.phase == Phase::kReady && now.world > world && walls(now) == 0 && now.snapshot.frame < 20;
  }));
}

TEST(Session, a_cut_beside_the_body_is_answered_by_a_sentence_and_the_world_goes_on) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  session.request(
      CutRequest{.blade = {.name = "cut", .from = {1, 1, 1}, .to = {1, 1, 1.1}, .depth = 0.01}, .body = 0});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return !now.error.empty(); }));
  EXPECT_NE(session.now().error.find("no cut"), std::string::npos);
  EXPECT_TRUE(session.now().cuts.empty()) << "nothing to save";
  const int frame = session.now().snapshot.frame;
  EXPECT_TRUE(wait_until(session, [frame](const SessionNow& now) { return now.snapshot.frame > frame + 3; }));
}

/// After half a second more: where the 121 vertices of the first body are on average, along y [m].
double mean_y(Session& session) {
  const double begin = session.now().snapshot.time;
  EXPECT_TRUE(
      wait_until(session, [begin](const SessionNow& now) { return now.snapshot.time > begin + 0.5; }));
  double mean = 0;
  for (const Vec3 u : session.now().snapshot.bodies[0].displacement) mean += double(u.y) / 121;
  return mean;
}

TEST(Session, wind_blows_a_hanging_cloth_where_it_is_asked_to_until_the_scenes_wind_is_changed) {
  const fs::path file = written(fresh_folder(), "flag.toml", R"([world]
duration = 1
gravity = [0, 0, -9.81]
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0, 0.2], columns = 10, rows = 10 }
[body.flag.hold.edge]
box = [[-0.01, -0.01, 0.19], [0.21, 0.01, 0.21]]
)");
  for (const double side : {-1.0, 1.0}) {
    Session session(file, {}, kOneThread);
    ASSERT_TRUE(wait_for_world(session)) << session.now().error;
    EXPECT_FALSE(session.now().is_haptic) << "no tool touches a cloth";
    session.request(WindRequest{.body = 0, .velocity = {0, 6 * side, 0}});
    EXPECT_GT(side * mean_y(session), 0.02) << "m, with the wind";
    session.request(ChangeRequest{"body.flag.damping.motion", "0.8"});
    EXPECT_GT(side * mean_y(session), 0.02) << "another key leaves the wind of a hand";
    session.request(ChangeRequest{"body.flag.wind.velocity", side > 0 ? "[0, -6, 0]" : "[0, 6, 0]"});
    mean_y(session);
    EXPECT_LT(side * mean_y(session), -0.01) << "the scene's wind is the latest now";
  }
}

TEST(Session, more_tension_leaves_whole_skin_where_it_is_and_opens_a_wound_wider) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const fs::path file = written(folder, "block.toml", test::block_scene_text("block.nii"));
  const auto largest = [](const SessionNow& now) {
    float most = 0;
    for (const Vec3 u : now.snapshot.bodies[0].displacement) most = std::max(most, norm(u));
    return double(most);
  };
  const auto settle = [](Session& session, double time) {
    return wait_until(session, [time](const SessionNow& now) { return now.snapshot.time > time; });
  };
  Session whole(file, {"incision.cut.start=0.19"}, kOneThread);  // not before the run's end
  ASSERT_TRUE(wait_for_world(whole)) << whole.now().error;
  whole.request(ChangeRequest{"body.block.skin.tension", "90"});
  ASSERT_TRUE(settle(whole, 0.15));
  EXPECT_LT(largest(whole.now()), 1e-5) << "m: the CT shows it at rest";
  Session cut(file, {}, kOneThread);
  ASSERT_TRUE(wait_for_world(cut) && settle(cut, 1.5));
  const double before = largest(cut.now());
  EXPECT_GT(before, 5e-4);
  cut.request(ChangeRequest{"body.block.skin.tension", "90"});
  ASSERT_TRUE(settle(cut, 3.5));
  EXPECT_GT(largest(cut.now()), 1.4 * before);
}

TEST(Session, the_ct_of_a_body_at_rest_is_made_once) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const fs::path file = written(folder, "block.toml", test::block_scene_text("block.nii"));
  Session session(file, {"incision.cut.start=0.3", "world.duration=0.5"}, kOneThread);
  const auto ask_until = [&](const std::function<bool(const SessionNow&)>& is_so) {
    return wait_until(session, [&](const SessionNow& now) {
      if (now.phase == Phase::kReady) session.request(CtRequest{});
      return now.ct && is_so(now);
    });
  };
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  ASSERT_TRUE(ask_until([](const SessionNow&) { return true; }));
  const std::shared_ptr<const DeformedCt> first = session.now().ct;
  ASSERT_TRUE(ask_until([](const SessionNow& now) { return now.snapshot.time > 0.25; }));
  EXPECT_EQ(session.now().ct, first) << "frames go on, and nothing moves";
  ASSERT_TRUE(ask_until([&](const SessionNow& now) { return now.snapshot.time > 0.35; }));
  EXPECT_NE(session.now().ct, first) << "it was cut";
  const int frame = session.now().ct->frame;
  ASSERT_TRUE(ask_until([&](const SessionNow& now) { return now.ct->frame > frame + 5; })) << "it opens";
  EXPECT_EQ(session.now().ct->there.has_value(), false);
}

/// A pad under a finger on a path.
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
Vec3d tool_force(const SessionNow& now) { return now.snapshot.tools[0].force; }
bool wait_for_time(Session& session, double time) {
  return wait_until(session, [time](const SessionNow& now) { return now.snapshot.time > time; });
}
/// What a finger on its path feels at a time [s], with a key changed before.
Vec3d force_at(const fs::path& file, double time, double change, const std::string& value) {
  Session session(file, {}, kOneThread);
  EXPECT_TRUE(wait_for_time(session, change)) << session.now().error;
  if (!value.empty()) session.request(ChangeRequest{"body.pad.young", value});
  EXPECT_TRUE(wait_for_time(session, time));
  EXPECT_EQ(session.now().error, "");
  return tool_force(session.now());
}

/// How a finger that slides rubs, force along over force across, over a stretch of its way.
double rubs(const fs::path& file, const std::string& friction) {
  Session session(file, {}, kOneThread);
  EXPECT_TRUE(wait_for_time(session, 0.4)) << session.now().error;
  if (!friction.empty()) session.request(ChangeRequest{"tool.finger.friction", friction});
  double sum = 0, last = 0;
  int count = 0;
  EXPECT_TRUE(wait_until(session, [&](const SessionNow& now) {
    const double x = now.snapshot.tools[0].pose.position.x;
    if (x > 0.025 && x < 0.042 && x != last) sum -= tool_force(now).x / tool_force(now).z, count++;
    last = x;
    return x >= 0.042;
  }));
  EXPECT_EQ(session.now().error, "");
  return sum / std::max(count, 1);
}

TEST(Session, a_stiffer_modulus_is_felt_at_once_as_if_the_body_had_been_made_of_it) {
  const std::string press =
      "path = [[0, 0.03, 0.03, 0.04], [0.3, 0.03, 0.03, 0.032], [9, 0.03, 0.03, 0.032]]";
  const Vec3d soft = force_at(pad_file(press), 0.9, 0.4, ""),
              changed = force_at(pad_file(press), 0.9, 0.4, "17e3"),
              made = force_at(pad_file(press, "17e3"), 0.9, 0.4, "");
  ASSERT_GT(soft.z, 0.05) << "N";
  EXPECT_LT(norm(changed - made), 1e-6 * norm(made));
  EXPECT_NEAR(norm(changed) / norm(soft), 3.4, 1e-6) << "times as stiff";
}

TEST(Session, a_slide_rubs_by_the_friction_that_was_asked_for_meanwhile) {
  const std::string slide =
      "path = [[0, 0.015, 0.03, 0.04], [0.3, 0.015, 0.03, 0.033], [1.5, 0.045, 0.03, 0.033]]\n"
      "interpolation = \"linear\"";
  const double little = rubs(pad_file(slide), ""), more = rubs(pad_file(slide), "0.8"),
               made = rubs(pad_file(slide, "5e3", "0.8"), "");
  EXPECT_GT(made, 2 * little);
  EXPECT_NEAR(more, made, 0.05 * made) << "and " << little << " with 0.3";
}

TEST(Session, what_a_hand_gives_an_elastic_body_it_gets_back_when_it_leaves) {
  const std::string press =
      "path = [[0, 0.03, 0.03, 0.04], [0.4, 0.03, 0.03, 0.031], [0.6, 0.03, 0.03, 0.031], [1, 0.03, 0.03, "
      "0.04], [9, 0.03, 0.03, 0.04]]";
  Session session(pad_file(press, "5e3", "0"), {}, kOneThread);
  ASSERT_TRUE(wait_for_time(session, 1.1)) << session.now().error;
  HapticSample most, before;
  double area = 0;  // under force over depth on the way in [J]
  for (const HapticSample& point : session.now().haptic[0]) {
    if (point.depth > before.depth) area += 0.5 * (point.force + before.force) * (point.depth - before.depth);
    before = point;
    if (point.work > most.work) most = point;
  }
  EXPECT_GT(most.force, 0.05) << "N";
  EXPECT_NEAR(most.work, area, 0.05 * area) << "by frames, where work is by ticks";
  EXPECT_LT(most.work, 0.5 * most.force * most.depth) << "a ball feels a pad stiffen as it sinks in";
  EXPECT_NEAR(session.now().haptic[0].back().work, 0, 0.02 * most.work) << "J";
}

TEST(Session, a_file_with_a_mistake_is_the_one_that_is_read_again) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const fs::path folder = fresh_folder(), bad = written(folder, "pad.toml", "[world]\nduration = -1\n");
  session.request(OpenRequest{.file = bad, .overrides = {}});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return now.phase == Phase::kFailed; }));
  fs::copy_file(pad_file("path = [[0, 0.03, 0.03, 0.04]]"), bad, fs::copy_options::overwrite_existing);
  session.request(ReloadRequest{});
  EXPECT_TRUE(wait_until(session, [](const SessionNow& now) {
    return now.phase == Phase::kReady && now.snapshot.bodies.size() == 1 &&
           now.snapshot.bodies[0].name == "pad";
  }));
}

TEST(Session, a_value_that_is_not_allowed_is_refused_with_the_scenes_own_sentence) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  session.request(ChangeRequest{"body.block.solver.sweeps", "-3"});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return !now.error.empty(); }));
  EXPECT_NE(session.now().error.find("expected a whole number"), std::string::npos) << session.now().error;
}

TEST(Session, a_scene_with_a_mistake_is_told_and_another_can_be_opened_after_it) {
  const fs::path bad = written(fresh_folder(), "bad.toml", "[world]\nduration = -1\n");
  Session session(bad, {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return now.phase == Phase::kFailed; }));
  EXPECT_NE(session.now().error.find("bad.toml:2"), std::string::npos) << session.now().error;
  session.request(ResetRequest{});  // again the same mistake, not a crash
  session.request(OpenRequest{.file = four_kinds_file(), .overrides = {}});
  EXPECT_TRUE(wait_for_world(session)) << session.now().error;
}

TEST(Session, a_file_that_was_mended_is_read_again_where_another_scene_was_before_it) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session)) << session.now().error;
  const fs::path bad = written(fresh_folder(), "bad.toml", "[world]\nduration = -1\n");
  session.request(OpenRequest{.file = bad, .overrides = {}});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return now.phase == Phase::kFailed; }));
  EXPECT_EQ(session.now().scene, nullptr) << "the scene before is none of this file";
  fs::copy_file(four_kinds_file(), bad, fs::copy_options::overwrite_existing);
  session.request(ResetRequest{});
  EXPECT_TRUE(
      wait_until(session, [&](const SessionNow& now) { return now.scene && now.scene->file == bad; }));
}

TEST(Session, a_step_whose_numbers_are_not_finite_is_told_when_it_was_asked_for_alone) {
  const fs::path file = written(fresh_folder(), "stiff.toml", R"([world]
duration = 0.5
frame_rate = 20
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 1], side = [1.5, 0, 0], up = [0, 0, 1], columns = 10, rows = 8 }
fabric = { density = 0.12, warp = 1e30, weft = 800, shear = 150, bend = 2 }
wind = { velocity = [100, 0, 0] }
)");
  Session session(file, {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return !now.error.empty() && !now.plays; }));
  const auto is_told = [](const SessionNow& now) {
    return now.error.find("not finite") != std::string::npos;
  };
  EXPECT_TRUE(is_told(session.now())) << session.now().error;
  session.request(ChangeRequest{"body.flag.wind.velocity", "[100, 0, 0]"});
  ASSERT_TRUE(wait_until(session, [](const SessionNow& now) { return now.error.empty(); }));
  session.request(StepRequest{});
  EXPECT_TRUE(wait_until(session, is_told));
}

TEST(Session, one_who_looks_away_for_a_second_costs_neither_ticks_nor_frames) {
  Session session(four_kinds_file(), {}, kOneThread);
  ASSERT_TRUE(wait_for_world(session, 5)) << session.now().error;
  const SessionNow& now = session.now();
  const double begin = now.snapshot.time;
  const haptics::TimingReport before = now.haptics;
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const SessionNow& after = session.now();
  EXPECT_GT(after.snapshot.time, begin + 0.5) << "s: frames went on";
  EXPECT_GT(after.haptics.ticks + after.haptics.missed, before.ticks + before.missed + 700);
  EXPECT_LT(after.haptics.period.largest, 0.5) << "s: no pause as long as the look away";
}

}  // namespace
}  // namespace turgor
