// Scene files of sessions, and waiting for their worlds.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/live/watched_session.hpp"

namespace turgor::test {

/// Writes a file and returns its path.
inline std::filesystem::path written(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& text) {
  std::ofstream(folder / name) << text;
  return folder / name;
}

/// A body of every model; no tool touches them before the mouse does.
inline std::filesystem::path four_kinds_file() {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  const std::string text = four_kinds_text(), no_cut = text.substr(0, text.find("[incision.cut]"));
  return written(folder, "four.toml", no_cut);
}

/// Waits until the world is ready and has this many frames.
inline bool wait_for_world(Session& session, int frames = 1) {
  return wait_until(session, [frames](const SessionStatus& now) {
    return now.phase == SessionStatus::Phase::kReady && now.snapshot.frame >= frames;
  });
}

/// Waits until the world is later than a time [s].
inline bool wait_for_time(Session& session, double time) {
  return wait_until(session, [time](const SessionStatus& now) { return now.snapshot.time > time; });
}

/// A pad with a finger on a path.
inline std::filesystem::path pad_file(const std::string& path, const std::string& young = "5e3",
                                      const std::string& mu = "0.3") {
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

}  // namespace turgor::test
