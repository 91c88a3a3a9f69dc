// A block of tissue under a fingertip: a scene whose run takes less than a second.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/sim/world.hpp"

namespace turgor::test {

/// A block of 60 × 60 × 30 mm, fixed at the bottom, pressed from above with a slide; `body` and `tool` add
/// keys.
inline std::string sfem_scene_text(const std::string& body = "", const std::string& tool = "") {
  return "[world]\nduration = 0.5\n"
         "[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }\n"
         "fixed = \"bottom\"\nyoung = 5e3\npoisson = 0.4\n" +
         body +
         "\n[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n"
         "press = { at_fraction = [0.3, 0.5, 1], to_fraction = [0.7, 0.5, 1], depth = 0.003, start = 0, "
         "duration = 0.1, hold = 0.05, slide = 0.15 }\n" +
         tool + "\n[output]\nsnapshots = { every = 0.25, size = [200, 160] }\nvideo = false\n";
}

inline Scene body_scene(const std::filesystem::path& folder, const std::string& body = "",
                        const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"body.pad.cache=" + (folder / "cache").string()};
  all.insert(all.end(), overrides.begin(), overrides.end());
  Result<Scene> scene = parse_scene(sfem_scene_text(body), folder / "pad.toml", all);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

inline World sfem_world(const Exec& exec, const Scene& scene) {
  Result<World> world = load_world(exec, scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

}  // namespace turgor::test
