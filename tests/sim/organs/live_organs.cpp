// Bodies in contact in a haptic session: its recording replays to the same bits.
#include <fstream>

#include "organs_scene.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A loose pad between a base and a finger, tied to the ground at one side.
std::string tied_pad() {
  return "[world]\nduration = 3\n" +
         test::block_text("base", "[-0.01, -0.01, -0.02]", "[0.08, 0.08, 0.02]", "[5, 5, 2]", "bottom") +
         test::block_text("pad", "[0, 0, 0]", "[0.06, 0.06, 0.015]", "[5, 5, 2]", "none") +
         "[contact.below]\nbetween = [\"pad\", \"base\"]\n"
         "[attachment.side]\nbetween = [\"pad\", \"ground\"]\nbox = [[-1, -1, -1], [0.001, 1, 1]]\n"
         "stiffness = 20\nslack = 0.0005\n"
         "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.008 }\n"
         "press = { at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0, duration = 0.2, hold = 3 }\n";
}

/// Presses the pad from above and pushes it aside.
void press(Session& session, Vec3d at, int teleports) {
  for (const MouseTool& mouse : session.now().mouse)
    mouse.device->set_target(
        {.pose = {at, {}}, .teleports = teleports, .teleport_to = at + Vec3d{0, 0, 0.006}});
  const double begin = session.now().snapshot.time;
  ASSERT_TRUE(
      test::wait_until(session, [&](const SessionStatus& now) { return now.snapshot.time > begin + 0.25; }));
}

std::uint64_t hash_of_replay(const HapticRecording& run, int threads) {
  const World world = test::replayed_world(run, threads);
  EXPECT_GT(world.coupling.contacts[0].samples.back().bearing, 0) << "the finger presses the pad on the base";
  return state_hash(world);
}

// A hand on a body that lies on another one replays to the same bits, on any number of threads.
TEST(LiveOrgans, HandOnLoosePad_ReplaysExactly) {
  const fs::path folder = test::fresh_folder();
  std::ofstream(folder / "pad.toml") << tied_pad();
  Session session(folder / "pad.toml", {}, test::kOneThread);
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  press(session, {0.03, 0.03, 0.020}, 1);
  press(session, {0.036, 0.03, 0.019}, 1);
  session.request(SaveRequest{folder / "haptic.h5"});
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  const Result<HapticRecording> run = read_haptic_recording(folder / "haptic.h5");
  ASSERT_TRUE(run) << session.now().saved << run.error().message;
  EXPECT_EQ(hash_of_replay(*run, 1), run->hash);
  EXPECT_EQ(hash_of_replay(*run, 3), run->hash);
}

}  // namespace
}  // namespace turgor
