// A cut in a session with a clock against the same frames without one, and against a cut of the scene.
#include <fstream>

#include <fmt/format.h>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/live/mouse_tools.hpp"

namespace turgor {
namespace {

constexpr double kDuration = 0.2;  // of the cut [s]

/// Text of a scene with a block that is not cut; writes its CT into the folder.
std::string uncut_scene(const std::filesystem::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::string text = test::block_scene_text("block.nii");
  const std::size_t begin = text.find("[incision.cut]");
  return text.erase(begin, text.find("[output]") - begin);
}

CutRequest cut_request() {
  return {.blade = {.name = "cut",
                    .from = {0.002, -0.02, -0.03},
                    .to = {0.002, -0.02, 0.03},
                    .depth = 0.012,
                    .duration = kDuration},
          .body = 0};
}

// The surface of a wound that was cut in a live session is that of the same frames without a clock.
TEST(LiveWound, EqualsFramesWithoutClock) {
  const std::filesystem::path folder = test::fresh_folder();
  const std::filesystem::path file = folder / "block.toml";
  std::ofstream(file) << uncut_scene(folder);
  const CutRequest request = cut_request();
  const auto pause = [](Session& session) {
    session.request(PaceRequest{.plays = false, .pace = 1});
    return test::wait_until(session, [](const SessionStatus& now) { return !now.plays; });
  };

  // cut live
  Session session(file, {}, {.threads = 2, .loop = test::kOneThread.loop});
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) {
    return now.phase == SessionStatus::Phase::kReady && now.snapshot.frame >= 3;
  })) << session.now().error;
  ASSERT_TRUE(pause(session));
  const int first = session.now().snapshot.frame;
  session.request(request), session.request(PaceRequest{});
  ASSERT_TRUE(
      test::wait_until(session, [&](const SessionStatus& now) { return now.snapshot.frame > first + 25; }));
  ASSERT_TRUE(pause(session));
  const WorldSnapshot& paused = session.now().snapshot;
  const BodySnapshot& live = paused.bodies[0];

  // the same frames
  const Exec exec(1);
  auto scene = std::make_shared<const Scene>(with_mouse_tools(read_scene(file).value()));
  World world = load_world(exec, *scene).value();
  while (world.frame < paused.frame) {
    if (world.frame == first) {
      ASSERT_TRUE(apply_request(exec, request, scene, world));
    }
    ASSERT_TRUE(step(exec, world));
  }
  WorldSnapshot frames;
  show(exec, world, frames);
  EXPECT_TRUE(live.triangles == frames.bodies[0].triangles);
  EXPECT_TRUE(live.rest == frames.bodies[0].rest);
  EXPECT_TRUE(live.x == frames.bodies[0].x);
  EXPECT_TRUE(live.normals == frames.bodies[0].normals);
  EXPECT_GT(live.triangles.size(), live.wall_begin) << "the wound has walls";
}

// A cut that a request starts between two frames has the bits of a cut that the scene starts at that time.
TEST(LiveWound, RequestEqualsCutOfScene) {
  const std::filesystem::path folder = test::fresh_folder();
  std::string text = uncut_scene(folder);
  constexpr int kFirst = 4, kFrames = 20;
  const Exec exec(1);

  // by request, with the tools of the mouse
  auto scene =
      std::make_shared<const Scene>(with_mouse_tools(parse_scene(text, folder / "live.toml").value()));
  World live = load_world(exec, *scene).value();
  const CutRequest request = cut_request();
  for (int frame = 0; frame < kFrames; frame++) {
    if (frame == kFirst) {
      ASSERT_TRUE(apply_request(exec, request, scene, live));
    }
    ASSERT_TRUE(step(exec, live));
  }

  // in the scene
  text += fmt::format(
      "[incision.cut]\nbody = \"block\"\nfrom = [0.002, -0.02, -0.03]\nto = [0.002, -0.02, 0.03]\n"
      "depth = 0.012\nduration = 0.2\nstart = {}\n",
      kFirst * live.dt);
  World cut = load_world(exec, parse_scene(text, folder / "cut.toml").value()).value();
  for (int frame = 0; frame < kFrames; frame++) ASSERT_TRUE(step(exec, cut));

  ASSERT_EQ(live.cuts[0].done, 1);
  WorldSnapshot of_live, of_cut;
  show(exec, live, of_live), show(exec, cut, of_cut);
  EXPECT_TRUE(of_live.bodies[0].triangles == of_cut.bodies[0].triangles);
  EXPECT_TRUE(of_live.bodies[0].x == of_cut.bodies[0].x);
}

}  // namespace
}  // namespace turgor
