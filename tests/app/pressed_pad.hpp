// Scene of a finite-element pad that a finger presses.
#pragma once

#include <string>

#include <fmt/format.h>

namespace turgor::test {

/// The scene's text. The run takes `duration` seconds; the press begins after `start` seconds and takes 0.3
/// s.
inline std::string pressed_pad_text(double duration, double start) {
  return fmt::format(R"([world]
duration = {}
frame_rate = 50
[body.pad]
model = "sfem"
block = {{ size = [0.04, 0.04, 0.02], count = [4, 4, 2] }}
fixed = {{ sides = "bottom", depth = 0.1 }}
cache = false
[tool.finger]
body = "pad"
shape = {{ sphere = 0.006 }}
press = {{ at_fraction = [0.5, 0.5, 1], depth = 0.003, start = {}, duration = 0.3 }}
[output]
snapshots = {{ every = 1.0, size = [64, 64] }}
)",
                     duration, start);
}

}  // namespace turgor::test
