// Error message of a scene that cannot be read.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"

namespace turgor::test {

inline std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Result<Scene> scene = parse_scene(text, "s.toml", overrides);
  return scene ? "no error" : scene.error().message;
}

}  // namespace turgor::test
