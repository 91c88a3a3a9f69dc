// Undo and redo of cuts and changes.
#include <fstream>

#include <gtest/gtest.h>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/live/edit_history.hpp"
#include "turgor/sim/live/mouse_tools.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::kOneThread;
using test::step_frames;
using test::wait_until;

const Exec kExec(1);

CutRequest cut_at(double x) {
  return {.blade = {.name = "cut", .from = {x, -0.02, -0.03}, .to = {x, -0.02, 0.03}, .depth = 0.012},
          .body = 0};
}

std::string block_text() {
  const std::string text = test::block_scene_text("block.nii");
  return text.substr(0, text.find("[incision.cut]"));
}

fs::path block_file() {
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::ofstream(folder / "block.toml") << block_text();
  return folder / "block.toml";
}

std::size_t walls(const SessionStatus& now) {
  const BodySnapshot& body = now.snapshot.bodies[0];
  return body.triangles.size() - body.wall_begin;
}

// The body has its positions from before the cut, no cut edge and no wound, and can be cut again.
TEST(Undo, CutIsTakenBackExactly) {
  const Result<Scene> read = read_scene(block_file());
  ASSERT_TRUE(read) << read.error().message;
  auto scene = std::make_shared<const Scene>(*read);
  Result<World> world = load_world(kExec, *scene);
  ASSERT_TRUE(world) << world.error().message;
  step_frames(*world, 3);
  const lattice::State before = world->lattice_bodies[0].state.host();
  ASSERT_TRUE(apply_request(kExec, cut_at(0.01), scene, *world));
  step_frames(*world, 10);
  const auto edges = world->lattice_bodies[0].state.host().cuts.edges.size();
  EXPECT_GT(edges, 20u);
  ASSERT_TRUE(apply_request(kExec, UndoCutRequest{}, scene, *world));
  const lattice::State& after = world->lattice_bodies[0].state.host();
  EXPECT_TRUE(world->cuts.empty());
  EXPECT_TRUE(after.cuts.edges.empty());
  EXPECT_EQ(after.motion.u.x, before.motion.u.x);
  EXPECT_EQ(after.motion.v.z, before.motion.v.z);
  step_frames(*world, 10);
  EXPECT_TRUE(world->lattice_bodies[0].state.host().cuts.edges.empty());
  ASSERT_TRUE(apply_request(kExec, cut_at(0.01), scene, *world));
  step_frames(*world, 10);
  EXPECT_EQ(world->lattice_bodies[0].state.host().cuts.edges.size(), edges) << "the same cut again";
}

// Another cut that the blade made after the request of the one taken back is made again.
TEST(Undo, EarlierCutIsMadeAgain) {
  auto scene = std::make_shared<const Scene>(read_scene(block_file()).value());
  World alone = load_world(kExec, *scene).value(), world = load_world(kExec, *scene).value();
  ASSERT_TRUE(apply_request(kExec, cut_at(0.01), scene, alone));
  step_frames(alone, 10);
  const auto edges = alone.lattice_bodies[0].state.host().cuts.edges.size();
  ASSERT_TRUE(apply_request(kExec, cut_at(0.01), scene, world));
  ASSERT_TRUE(apply_request(kExec, cut_at(-0.01), scene, world));
  step_frames(world, 10);
  EXPECT_GT(world.lattice_bodies[0].state.host().cuts.edges.size(), edges);
  ASSERT_TRUE(apply_request(kExec, UndoCutRequest{}, scene, world));
  step_frames(world, 10);
  ASSERT_EQ(world.cuts.size(), 1u);
  EXPECT_EQ(world.cuts[0].edges, alone.cuts[0].edges);
  EXPECT_EQ(world.lattice_bodies[0].state.host().cuts.edges.size(), edges);
}

// Undo of a second cut restores the contact samples that it separated. The next step reads no virtual node of
// that cut.
TEST(Undo, SecondCutLeavesContactSamples) {
  auto scene = std::make_shared<const Scene>(
      with_mouse_tools(test::block_scene(test::fresh_folder(), {"body.block.tissue.partial_cells=true"})));
  World world = test::block_world(kExec, *scene);
  LatticeBody& body = world.lattice_bodies[0];
  begin_haptics(body, world.tools);
  step_frames(world, 10);
  ASSERT_EQ(world.cuts[0].done, 1);
  refresh_surface(kExec, body);
  const std::size_t samples = body.touch.samples.size();
  ASSERT_TRUE(apply_request(kExec, cut_at(0.03), scene, world));
  step_frames(world, 10);
  refresh_surface(kExec, body);
  EXPECT_NE(body.touch.samples.size(), samples) << "the cut separates samples and adds lips";
  ASSERT_TRUE(apply_request(kExec, UndoCutRequest{}, scene, world));
  step_frames(world, 1);
  const std::size_t nodes = body.state.host().motion.u.x.size() + body.state.virtual_u().size();
  ASSERT_FALSE(body.touch.points.empty());
  for (const lattice::EmbeddedPoint& point : body.touch.points)
    for (const int corner : point.corner) ASSERT_LT(std::size_t(corner), nodes);
  refresh_surface(kExec, body);
  EXPECT_EQ(body.touch.samples.size(), samples);
}

// Cuts of the scene are no edits.
TEST(Undo, CutOfSceneStays) {
  const Result<Scene> read = parse_scene(
      block_text() +
          "[incision.own]\nbody = \"block\"\nfrom = [0.01, -0.02, -0.03]\nto = [0.01, -0.02, 0.03]\n",
      block_file());
  ASSERT_TRUE(read) << read.error().message;
  auto scene = std::make_shared<const Scene>(*read);
  Result<World> world = load_world(kExec, *scene);
  ASSERT_TRUE(world) << world.error().message;
  const Status status = apply_request(kExec, UndoCutRequest{}, scene, *world);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "no undo: there is no cut by hand");
  EXPECT_EQ(world->cuts.size(), 1u);
}

// A session takes cuts and changes back and repeats them, and reports the wound in between.
TEST(Undo, SessionUndoesAndRedoes) {
  Session session(block_file(), {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  EXPECT_EQ(session.now().undo, "");
  session.request(cut_at(0.01));
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.cut_result.is_measured; }));
  EXPECT_EQ(session.now().undo, "cut of 60 mm");
  EXPECT_NEAR(session.now().cut_result.length, 0.06, 0.012) << "m: the lips end within a cell of the blade";
  EXPECT_EQ(session.now().cut_result.depth, 0.012);
  session.request(ChangeRequest{"body.block.skin.tension", "90"});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.scene->overrides.empty(); }));
  EXPECT_EQ(session.now().undo, "body.block.skin.tension");

  // both back, then both again
  session.request(UndoRequest{}), session.request(UndoRequest{});
  ASSERT_TRUE(
      wait_until(session, [](const SessionStatus& now) { return now.cuts.empty() && walls(now) == 0; }));
  EXPECT_TRUE(session.now().scene->overrides.empty()) << "the scene's own tension";
  EXPECT_EQ(session.now().redo, "cut of 60 mm");
  session.request(RedoRequest{}), session.request(RedoRequest{});
  ASSERT_TRUE(
      wait_until(session, [](const SessionStatus& now) { return now.cuts.size() == 1 && walls(now) > 30; }));
  EXPECT_EQ(session.now().scene->overrides, std::vector<std::string>{"body.block.skin.tension=90"});
  EXPECT_EQ(session.now().redo, "");
}

// A recording with an undo is replayed with the same bits.
TEST(Undo, RecordingIsReplayedExactly) {
  const fs::path file = block_file();
  const fs::path saved = file.parent_path() / "run.h5";
  Session session(file, {}, kOneThread);
  const auto advance = [&session](int frames) {
    const int from = session.now().snapshot.frame;
    EXPECT_TRUE(
        wait_until(session, [=](const SessionStatus& now) { return now.snapshot.frame > from + frames; }));
  };
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  session.request(cut_at(0.01)), advance(5);
  session.request(UndoRequest{}), advance(3);
  session.request(cut_at(-0.01)), advance(5);
  session.request(ChangeRequest{"body.block.skin.tension", "90"}), advance(2);
  session.request(UndoRequest{}), advance(2);
  session.request(SaveRequest{saved});
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  const Result<HapticRecording> run = read_haptic_recording(saved);
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(run->requests.size(), 5u);
  const World world = test::replayed_world(*run, 1);
  EXPECT_EQ(state_hash(world), run->hash);
}

// Quick changes of one key are one edit, and a new edit ends the chance to repeat.
TEST(Undo, QuickChangesOfOneKeyAreOneEdit) {
  EditHistory history;
  add_edit({ChangeRequest{"a", "1"}, ChangeRequest{"a", std::nullopt}}, history);
  add_edit({ChangeRequest{"a", "2"}, ChangeRequest{"a", "1"}}, history);
  ASSERT_EQ(history.done.size(), 1u);
  EXPECT_EQ(std::get<ChangeRequest>(history.done[0].redo).value, "2");
  EXPECT_EQ(std::get<ChangeRequest>(history.done[0].undo).value, std::nullopt);
  add_edit({ChangeRequest{"b", "1"}, ChangeRequest{"b", "0"}}, history);
  EXPECT_EQ(history.done.size(), 2u);
  history.undone.push_back(history.done.back()), history.done.pop_back();
  add_edit({cut_at(0), UndoCutRequest{}}, history);
  EXPECT_TRUE(history.undone.empty());
  forget_world(history);
  EXPECT_EQ(undo_text(history), "a");
}

// All pulls of one drag are one edit, also of a drag that pauses. The next drag is another one.
TEST(Undo, DragOfStitchIsOneEdit) {
  EditHistory history;
  const auto pull_later = [&](double tension, bool continues) {
    history.latest -= std::chrono::seconds(10);
    add_edit({TightenRequest{.tension = tension, .continues = continues}, TightenRequest{}}, history);
  };
  pull_later(0.3, false);
  pull_later(0.5, true);
  ASSERT_EQ(history.done.size(), 1u);
  EXPECT_EQ(std::get<TightenRequest>(history.done[0].redo).tension, 0.5);
  pull_later(0.6, false);
  EXPECT_EQ(history.done.size(), 2u);
}

// Winds of one drag are one edit. Undo restores the scene's wind, redo blows again; a new world has neither.
TEST(Undo, WindIsTakenBack) {
  const std::string text =
      "[body.flag]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0, 0.2], "
      "columns = 4, rows = 4 }\nwind = { velocity = [1, 2, 0], turns = [[0.5, 3, 0, 0]] }\n"
      "[body.flag.hold.edge]\nbox = [[-0.01, -0.01, 0.19], [0.21, 0.01, 0.21]]\n";
  const Result<Scene> read = parse_scene(text, "flag.toml");
  ASSERT_TRUE(read) << read.error().message;
  auto scene = std::make_shared<const Scene>(*read);
  Result<World> world = load_world(kExec, *scene);
  ASSERT_TRUE(world) << world.error().message;
  const ClothBody& flag = world->cloth_bodies[0];
  EditHistory history;
  for (const double speed : {3.0, 6.0}) {
    const WindRequest wind{0, Vec3d{0, speed, 0}};
    ASSERT_TRUE(apply_request(kExec, wind, scene, *world));
    add_edit({wind, WindRequest{0, std::nullopt}}, history);
  }
  ASSERT_EQ(history.done.size(), 1u);
  EXPECT_EQ(undo_text(history), "wind of 6.0 m/s");
  EXPECT_EQ(flag.air.velocity.y, 6);
  EXPECT_TRUE(flag.turns.empty());
  ASSERT_TRUE(apply_request(kExec, std::get<WindRequest>(history.done[0].undo), scene, *world));
  EXPECT_EQ(flag.air, scene->cloth_bodies[0].air);
  EXPECT_EQ(flag.turns, scene->cloth_bodies[0].turns);
  forget_world(history);
  EXPECT_TRUE(history.done.empty());
}

// A session names the wind that undo and redo concern.
TEST(Undo, SessionTakesWindBack) {
  const fs::path file = test::fresh_folder() / "flag.toml";
  std::ofstream(file) << "[body.flag]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.2, 0, 0], "
                         "up = [0, 0, 0.2], columns = 4, rows = 4 }\n"
                         "[body.flag.hold.edge]\nbox = [[-0.01, -0.01, 0.19], [0.21, 0.01, 0.21]]\n";
  Session session(file, {}, kOneThread);
  const auto says = [&session](const char* undo, const char* redo) {
    return wait_until(session,
                      [=](const SessionStatus& now) { return now.undo == undo && now.redo == redo; });
  };
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  session.request(WindRequest{.body = 0, .velocity = Vec3d{0, 4, 0}});
  EXPECT_TRUE(says("wind of 4.0 m/s", ""));
  session.request(UndoRequest{});
  EXPECT_TRUE(says("", "wind of 4.0 m/s"));
  session.request(RedoRequest{});
  EXPECT_TRUE(says("wind of 4.0 m/s", ""));
  session.request(WindRequest{.body = 7, .velocity = Vec3d{0, 4, 0}});
  EXPECT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.error.empty(); }));
}

// A paused session waits for Play, also after another scene is opened; an empty one waits for a scene.
TEST(PausedSession, WaitsForPlay) {
  SessionParams params = kOneThread;
  params.plays = false;
  Session session({}, {}, params);
  ASSERT_TRUE(wait_until(session,
                         [](const SessionStatus& now) { return now.phase == SessionStatus::Phase::kEmpty; }));
  session.request(ResetRequest{}), session.request(ReloadRequest{});
  session.request(OpenRequest{block_file(), {}});
  ASSERT_TRUE(wait_until(session,
                         [](const SessionStatus& now) { return now.phase == SessionStatus::Phase::kReady; }));
  EXPECT_FALSE(session.now().plays);
  EXPECT_EQ(session.now().snapshot.frame, 0);
  EXPECT_FALSE(session.now().snapshot.bodies.empty()) << "it is shown";
  session.request(PaceRequest{});
  EXPECT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 3; }));
}

}  // namespace
}  // namespace turgor
