// Stitches by requests: bits, pulls, undo, recordings and saved scenes.
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/scene/scene_edit.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::kOneThread;
using test::step_frames;
using test::wait_until;

const Exec kAlone(1);
const std::vector<Vec3d> kPoints = {
    {-0.010, -0.019, 0.004}, {-0.010, -0.014, 0.004}, {0.014, -0.014, 0.004}, {0.014, -0.019, 0.004}};
constexpr int kStart = 8;  // frames before the stitch

StitchRequest stitch_with(std::optional<double> tension) {
  return {.body = 0, .wound = {}, .through = kPoints, .tension = tension, .duration = 0.2};
}

std::string numbers(Vec3d p) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", p.x, p.y, p.z); }

/// The block with its cut, and keys after it.
Scene block_with(const fs::path& folder, const std::string& keys, double duration = 2, bool partial = false) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  Result<Scene> scene = parse_scene(test::block_scene_text("block.nii") + keys, folder / "block.toml",
                                    {fmt::format("world.duration={}", duration),
                                     fmt::format("body.block.tissue.partial_cells={}", partial)});
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

const lattice::Stitch& stitch_of(const World& world) {
  return world.sutures.back().closure->stitches.front();
}

// A stitch by a request gives the bits of the same stitch in a scene, with a tension and until closed, on any
// number of threads.
TEST(LiveStitch, HasBitsOfStitchInScene) {
  const fs::path folder = test::fresh_folder();
  for (const std::optional<double> tension : {std::optional<double>(0.6), std::optional<double>()}) {
    // in the scene
    const double dt = 1 / 50.0, start = kStart * dt + dt;
    std::string keys = "[suture.one]\nwound = \"cut\"\nthrough = [";
    for (const Vec3d p : kPoints) keys += numbers(p) + ", ";
    keys += fmt::format("]\nstart = {:.17g}\nduration = 0.2\n", start);
    if (tension) keys += fmt::format("tension = {}\n", *tension);
    World in_scene = test::block_world(kAlone, block_with(folder, keys));
    // by a request
    auto scene = std::make_shared<const Scene>(block_with(folder, ""));
    World live = test::block_world(kAlone, *scene);
    const Exec two(2);
    step_frames(live, kStart, two), step_frames(in_scene, kStart);
    const Status laid = apply_request(two, stitch_with(tension), scene, live);
    ASSERT_TRUE(laid) << laid.error().message;
    const auto uncut = state_hash(live);
    step_frames(live, 25, two), step_frames(in_scene, 25);
    EXPECT_NE(state_hash(live), uncut);
    EXPECT_EQ(state_hash(live), state_hash(in_scene));
    EXPECT_EQ(stitch_of(live).tension, stitch_of(in_scene).tension);
    EXPECT_GT(stitch_of(live).tension, 0.01) << "N";
  }
}

// A stitch is pulled further: its force follows the goal and the law of the thread, and the wound closes.
void expect_tightened(bool partial) {
  const fs::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(block_with(folder, "", 2, partial));
  World world = test::block_world(kAlone, *scene);
  step_frames(world, 25);
  ASSERT_TRUE(apply_request(kAlone, stitch_with(0.15), scene, world));
  step_frames(world, 60);
  std::vector<HandStitch> seen = hand_stitches(*scene, world);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].phase, lattice::StitchPhase::kKnotted);
  const double gape = seen[0].gape, tension = seen[0].tension;
  EXPECT_GT(gape, 1e-4) << "m";
  ASSERT_TRUE(apply_request(kAlone, TightenRequest{.suture = 0, .tension = 0.5}, scene, world));
  step_frames(world, 1);
  EXPECT_NEAR(stitch_of(world).tension, tension, 0.1 * tension) << "N: it begins where it was";
  step_frames(world, 60);
  seen = hand_stitches(*scene, world);
  EXPECT_LT(seen[0].gape, gape - 1e-4) << "m";
  EXPECT_GT(seen[0].tension, 2 * tension) << "N";
  EXPECT_EQ(seen[0].request.tension, 0.5);
  const lattice::Stitch& stitch = stitch_of(world);
  const double beyond = loop_length(stitch, world.lattice_bodies[0].state->motion) - stitch.length,
               law = world.sutures[0].scene.thread.stiffness / stitch.length * beyond;
  EXPECT_NEAR(stitch.tension, law, 0.01 * law) << "N";
  // until the lips meet
  ASSERT_TRUE(apply_request(kAlone, TightenRequest{.suture = 0, .tension = {}}, scene, world));
  step_frames(world, 60);
  EXPECT_LT(hand_stitches(*scene, world)[0].gape, 3e-4) << "m";
}
TEST(LiveStitch, IsTightened) { expect_tightened(false); }
TEST(LiveStitch, IsTightenedInPartialCells) { expect_tightened(true); }

// Without the stitch the wound opens again, as far as one that was never stitched.
TEST(LiveStitch, RemovedStitchOpensWound) {
  const fs::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(block_with(folder, ""));
  World world = test::block_world(kAlone, *scene);
  step_frames(world, 30);
  Measures measures = make_measures(world);
  const auto gape = [&] {
    step_frames(world, 60);
    measure_frame(kAlone, world, FrameReport{}, false, measures);
    return measures.cuts[0].wound.gape_mean;
  };
  const double open = gape();
  ASSERT_TRUE(apply_request(kAlone, stitch_with({}), scene, world));
  EXPECT_LT(gape(), 0.9 * open);
  ASSERT_EQ(measures.sutures.size(), 1u);
  EXPECT_EQ(measures.sutures[0].wound, "cut");
  ASSERT_TRUE(apply_request(kAlone, UndoStitchRequest{}, scene, world));
  EXPECT_NEAR(gape(), open, 0.02 * open);
  EXPECT_TRUE(measures.sutures.empty());
  EXPECT_FALSE(apply_request(kAlone, UndoStitchRequest{}, scene, world));
}

// A stitch that is taken back leaves the contact of the wound's walls to the stitches that stay.
TEST(LiveStitch, RemovedStitchLeavesWalls) {
  const fs::path folder = test::fresh_folder();
  std::string keys = "[suture.later]\nwound = \"cut\"\nstart = 0.5\nduration = 0.1\ntension = 2\nthrough = [";
  for (const Vec3d p : kPoints) keys += numbers(p - Vec3d{0, 0, 0.016}) + ", ";
  auto scene = std::make_shared<const Scene>(block_with(folder, keys + "]\n", 4));
  World world = test::block_world(kAlone, *scene);
  step_frames(world, kStart);
  ASSERT_TRUE(apply_request(kAlone, stitch_with(2), scene, world));
  step_frames(world, 60);
  const auto pressure = [&] {
    double sum = 0;
    for (const Suture& suture : world.sutures) sum += suture.closure ? wall_force(*suture.closure) : 0;
    return sum;
  };
  EXPECT_GT(pressure(), 0.05) << "N";
  ASSERT_TRUE(apply_request(kAlone, UndoStitchRequest{}, scene, world));
  step_frames(world, 60);
  EXPECT_GT(pressure(), 0.05) << "N";
}

// Wrong stitches are refused with the reason, and change nothing.
TEST(LiveStitch, WrongRequestsAreRefused) {
  const fs::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(block_with(folder, ""));
  World world = test::block_world(kAlone, *scene);
  const auto error = [&](const auto& request) {
    const Status status = apply_request(kAlone, request, scene, world);
    return status ? std::string() : status.error().message;
  };
  const auto contains = [](const std::string& text, const char* words) {
    return text.find(words) != std::string::npos;
  };
  EXPECT_TRUE(contains(error(stitch_with(1)), "both sides of a complete cut")) << "before the cut";
  step_frames(world, kStart);
  StitchRequest request = stitch_with(1);
  request.thread = "rope";
  EXPECT_TRUE(contains(error(request), "unknown thread rope"));
  request = stitch_with(-1);
  EXPECT_TRUE(contains(error(request), "tension"));
  request = stitch_with(1), request.through.resize(1);
  EXPECT_TRUE(contains(error(request), "two to 64 points"));
  request = stitch_with(1), request.body = 3;
  EXPECT_TRUE(contains(error(request), "unknown lattice body"));
  request = stitch_with(1), request.wound = 4;
  EXPECT_TRUE(contains(error(request), "complete cut of the body"));
  request = stitch_with(1);
  for (Vec3d& p : request.through) p.x += 0.03;
  EXPECT_TRUE(contains(error(request), "both sides")) << "all on one side";
  request.wound = 0;
  EXPECT_TRUE(contains(error(request), "points on both sides of the wound cut")) << error(request);
  request = stitch_with(1);
  for (Vec3d& p : request.through) p.y -= 0.02;
  EXPECT_TRUE(contains(error(request), "through air"));
  EXPECT_TRUE(contains(error(TightenRequest{}), "expected a stitch by hand"));
  EXPECT_TRUE(world.sutures.empty());
}

// Cuts and stitches of a session are taken back in order, and a recording repeats them bit by bit.
TEST(LiveStitch, SessionUndoesAndRecords) {
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::ofstream(folder / "block.toml") << test::block_scene_text("block.nii");
  Session session(folder / "block.toml", {}, kOneThread);
  const auto advance = [&session](int frames) {
    const int from = session.now().snapshot.frame;
    return wait_until(session, [=](const SessionStatus& now) { return now.snapshot.frame > from + frames; });
  };
  ASSERT_TRUE(advance(kStart));
  session.request(stitch_with(0.3));
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) {
    return now.stitches.size() == 1 && now.stitches[0].tension > 0.1;
  }));
  EXPECT_EQ(session.now().undo, "stitch of 24 mm");
  EXPECT_EQ(session.now().stitches[0].request.wound, 0);
  session.request(TightenRequest{.suture = 0, .tension = 0.4, .duration = 0.1});
  session.request(TightenRequest{.suture = 0, .tension = 0.5, .duration = 0.1});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.undo == "tension of 0.5 N"; }));
  ASSERT_TRUE(advance(5));
  session.request(UndoRequest{});
  ASSERT_TRUE(
      wait_until(session, [](const SessionStatus& now) { return now.stitches[0].request.tension == 0.3; }));
  session.request(UndoRequest{});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.stitches.empty(); }));
  EXPECT_EQ(session.now().redo, "stitch of 24 mm");
  session.request(RedoRequest{});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.stitches.size() == 1; }));
  ASSERT_TRUE(advance(5));
  const fs::path saved = folder / "run.h5";
  session.request(SaveRequest{saved});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  // replay
  const Result<HapticRecording> run = read_haptic_recording(saved);
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(run->requests.size(), 6u);
  const World world = test::replayed_world(*run, 1);
  EXPECT_EQ(state_hash(world), run->hash);
}

/// A cut by hand beside that of the scene.
CutRequest second_cut() {
  return {.blade = {.name = "hand",
                    .from = {0.03, -0.02, -0.03},
                    .to = {0.03, -0.02, 0.03},
                    .depth = 0.012,
                    .duration = 0.1},
          .body = 0};
}

// A cut whose wound is stitched stays until the stitch is taken back.
TEST(LiveStitch, StitchedCutStays) {
  const fs::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(block_with(folder, ""));
  World world = test::block_world(kAlone, *scene);
  ASSERT_TRUE(apply_request(kAlone, second_cut(), scene, world));
  step_frames(world, kStart);
  StitchRequest stitch = stitch_with(0.3);
  for (Vec3d& p : stitch.through) p.x += 0.03;
  ASSERT_TRUE(apply_request(kAlone, stitch, scene, world));
  EXPECT_EQ(world.sutures[0].scene.incision, 1) << "the nearest wound";
  step_frames(world, 3);
  EXPECT_FALSE(apply_request(kAlone, UndoCutRequest{}, scene, world));
  ASSERT_TRUE(apply_request(kAlone, UndoStitchRequest{}, scene, world));
  EXPECT_TRUE(apply_request(kAlone, UndoCutRequest{}, scene, world));
}

// Undo of a later cut restores a stitch: it is embedded in the restored cells, with its tension of that time.
TEST(LiveStitch, UndoneCutRestoresStitch) {
  const fs::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(block_with(folder, "", 2, true));
  World world = test::block_world(kAlone, *scene);
  step_frames(world, kStart);
  ASSERT_TRUE(apply_request(kAlone, stitch_with(0.3), scene, world));
  step_frames(world, 10);
  const double tension = stitch_of(world).tension;
  ASSERT_TRUE(apply_request(kAlone, second_cut(), scene, world));
  step_frames(world, 10);
  EXPECT_NE(stitch_of(world).tension, tension) << "N: it was still pulled";
  ASSERT_TRUE(apply_request(kAlone, UndoCutRequest{}, scene, world));
  EXPECT_EQ(world.sutures[0].closure->version, cut_version(world.lattice_bodies[0].state.cuts()));
  EXPECT_EQ(stitch_of(world).tension, tension) << "N";
}

// A stitch that tore cannot be pulled less. Undo says so, and the next one takes the stitch back.
TEST(LiveStitch, TornStitchDoesNotBlockUndo) {
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::ofstream(folder / "block.toml") << test::block_scene_text("block.nii");
  Session session(folder / "block.toml", {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > kStart; }));
  session.request(stitch_with(0.3));
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) {
    return now.stitches.size() == 1 && now.stitches[0].tension > 0.1;
  }));
  session.request(TightenRequest{.suture = 0, .tension = 1e4, .duration = 0.1});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) {
    return now.stitches[0].phase == lattice::StitchPhase::kBroken ||
           now.stitches[0].phase == lattice::StitchPhase::kPulledOut;
  }));
  session.request(UndoRequest{});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.edits == 1; }));
  EXPECT_EQ(session.now().edited, "not undone: no pull: the stitch tore");
  EXPECT_EQ(session.now().undo, "stitch of 24 mm");
  session.request(UndoRequest{});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.edits == 2; }));
  EXPECT_EQ(session.now().edited, "undone: stitch of 24 mm");
  EXPECT_TRUE(session.now().stitches.empty());
}

// Stitches are saved as sutures of the cut by hand, or of the scene.
TEST(LiveStitch, IsSavedWithScene) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = block_with(folder, "");
  const std::vector<lattice::Incision> cuts = {{.name = "block",
                                                .from = {0.03, -0.02, -0.03},
                                                .to = {0.03, -0.02, 0.03},
                                                .depth = 0.012,
                                                .duration = 0.1}};
  const std::vector<SavedStitch> stitches = {
      {.wound = 0, .through = kPoints, .thread = "nylon 0", .tension = 0.25},
      {.wound = 1, .through = kPoints, .thread = "nylon 5-0", .tension = {}}};
  const std::string text = scene.text + incisions_text(scene, cuts) + sutures_text(scene, cuts, stitches);
  const Result<Scene> saved = parse_scene(text, folder / "block.toml", {"world.duration=2"});
  ASSERT_TRUE(saved) << saved.error().message;
  ASSERT_EQ(saved->sutures.size(), 2u);
  EXPECT_EQ(saved->sutures[0].incision, 0);
  EXPECT_EQ(saved->sutures[0].material, "nylon 0");
  EXPECT_EQ(saved->sutures[0].pull.tension, 0.25);
  EXPECT_EQ(saved->sutures[0].through, kPoints);
  EXPECT_EQ(saved->sutures[1].incision, 1);
  EXPECT_TRUE(saved->sutures[1].pull.until_closed);
  EXPECT_EQ(saved->sutures[1].pull.start, 0.1) << "s: the end of its cut";
}

}  // namespace
}  // namespace turgor
