// Definitions of worlds for tests of the C interface.
#pragma once

#include <string>

#include <gtest/gtest.h>
#include <turgor.h>

namespace turgor::test {

/// Defaults with the text of a scene, which must outlive the definition.
inline tg_world_def def_of(const char* text, int threads = 2) {
  tg_world_def def;
  EXPECT_EQ(tg_default_world_def(&def, sizeof def), TG_OK);
  def.text = text, def.threads = threads;
  return def;
}

/// Scene with a pad of 60 x 60 x 30 mm that stands on its bottom, and the keys of its tool.
inline std::string pad_scene(const std::string& tool) {
  return R"([world]
duration = 1
frame_rate = 50
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
young = 5e3
poisson = 0.4
cache = false
)" + tool;
}

}  // namespace turgor::test
