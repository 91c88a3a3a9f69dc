// Scenes of cloth on other bodies, and helpers that run them.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor::test {

constexpr double kGravity = 9.81;  // [m/s²]

/// A block "pad" of 60 × 60 × 30 mm and 5 kPa, fixed at its bottom.
inline constexpr const char* kPad = R"(
[world]
gravity = [0, 0, -9.81]
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }
fixed = { sides = "bottom", depth = 0 }
young = 5e3
poisson = 0
precision = "double"
cache = false
)";

/// A heavy sheet that covers the pad, 3 mm above it.
inline constexpr const char* kSheetOnPad = R"(
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0.033], side = [0.06, 0, 0], up = [0, 0.06, 0], columns = 24, rows = 24 }
fabric = { law = "springs", density = 10 }
solver = { method = "sweeps" }
collision = { self = false, thickness = 0.001 }
wind = { density = 0 }
[body.sheet.obstacle.pad]
body = "pad"
)";

inline World must_load_scene(const Scene& scene, const Exec& exec = Exec(1)) {
  Result<World> world = load_world(exec, scene);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

/// 40 mm of fat on bone, "fat", with gravity towards +y, from the front. `rest` adds its tissue and other
/// tables. The CT is written into the folder.
inline World fat_on_bone(const std::filesystem::path& folder, const std::string& rest,
                         const std::vector<std::string>& overrides = {}, const Exec& exec = Exec(1)) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  const std::string text = R"(
[world]
gravity = [0, 9.81, 0]
[body.fat]
model = "lattice"
ct = "block.nii"
block = 2
gravity = false
skin = false
)";
  const Result<Scene> scene = parse_scene(text + rest, folder / "sheet.toml", overrides);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return must_load_scene(*scene, exec);
}

inline World must_load(const std::string& text, const std::vector<std::string>& overrides = {},
                       const Exec& exec = Exec(1)) {
  const Result<Scene> scene = parse_scene(text, "sheet.toml", overrides);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return must_load_scene(*scene, exec);
}

inline void run(World& world, int frames, const Exec& exec = Exec(1)) {
  for (int n = 0; n < frames; n++) {
    const Result<FrameReport> report = step(exec, world);
    ASSERT_TRUE(report && report->finite) << "frame " << world.frame;
  }
}

inline Vec3d mean_of_last(const std::vector<Vec3d>& forces, std::size_t count) {
  Vec3d sum;
  for (std::size_t n = forces.size() - count; n < forces.size(); n++) sum += forces[n];
  return sum / double(count);
}

}  // namespace turgor::test
