// Scene files that a session loads, reloads and refuses.
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
using test::wait_for_world;
using test::wait_until;
using test::written;
using Phase = SessionStatus::Phase;

// The session reports the progress of loading.
TEST(SessionFiles, ReportsLoadingProgress) {
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

// A reload reads the file that failed.
TEST(SessionFiles, ReloadReadsFailedFile) {
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

// A wrong scene is reported, and another one can be opened after it.
TEST(SessionFiles, OpensSceneAfterError) {
  const fs::path bad = written(fresh_folder(), "bad.toml", "[world]\nduration = -1\n");
  Session session(bad, {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.phase == Phase::kFailed; }));
  EXPECT_NE(session.now().error.find("bad.toml:2"), std::string::npos) << session.now().error;
  session.request(ResetRequest{});  // the same error again, not a crash
  session.request(OpenRequest{.file = four_kinds_file(), .overrides = {}});
  EXPECT_TRUE(wait_for_world(session)) << session.now().error;
}

// A reset reads the corrected file, even if another scene was open before.
TEST(SessionFiles, ResetReadsCorrectedFile) {
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

}  // namespace
}  // namespace turgor
