// A world with a body of every model, small enough that a frame takes milliseconds.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/sim/block_scene.hpp"

namespace turgor::test {

/// Indices of its tools.
constexpr int kFinger = 0, kBall = 1, kTip = 2;

/// A weight that falls on the ground, an elastic pad with a finger and a cloth on it, a phantom liver with a
/// ball, and a block of fat that is cut while a ball presses it.
inline std::string four_kinds_text() {
  return R"([world]
duration = 0.3
frame_rate = 50
gravity = [0, 0, -9.81]
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
young = 5e3
poisson = 0.4
cache = false
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.3 }
bulge = 0.4
[body.block]
model = "lattice"
ct = "block.nii"
block = 2
fixed = "bone"
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0.032], side = [0.06, 0, 0], up = [0, 0.06, 0], columns = 12, rows = 12 }
fabric = { law = "springs", density = 2 }
solver = { method = "sweeps" }
collision = { thickness = 0.002 }
[body.sheet.obstacle.pad]
body = "pad"
[body.sheet.obstacle.floor]
plane = { through = [0, 0, -0.01], normal = [0, 0, 1] }
[body.weight]
model = "rigid"
shape = { sphere = 0.01 }
at = [0, 0.2, 0.011]
turn = [20, 0, 30]
mass = 0.02
[contact.weight-floor]
between = ["weight", "ground"]
[incision.cut]
body = "block"
from = [0.002, -0.02, -0.03]
to = [0.002, -0.02, 0.03]
depth = 0.012
start = 0.05
duration = 0.1
[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
press = { at_fraction = [0.3, 0.5, 1], depth = 0.003, start = 0, duration = 0.1, hold = 0.05 }
[tool.ball]
body = "liver"
shape = { sphere = 0.006 }
press = { at_fraction = [0.3, 0.5, 1], depth = 0.006, start = 0, duration = 0.1, hold = 0.05 }
[tool.tip]
body = "block"
shape = { sphere = 0.014 }
press = { at_fraction = [0.8, 0, 0.5], depth = 0.005, start = 0, duration = 0.1, hold = 0.05 }
[output]
snapshots = { every = 0.1, size = [160, 120] }
)";
}

/// The scene, with its CT written into the same folder.
inline Scene four_kinds_scene(const std::filesystem::path& folder,
                              const std::vector<std::string>& overrides = {}) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  Result<Scene> scene = parse_scene(four_kinds_text(), folder / "four.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

}  // namespace turgor::test
