// Adjustable keys of a scene with their units, limits, descriptions and values.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_key.hpp"

namespace turgor {

/// A key with one to three numbers.
struct Parameter {
  SceneKey key;
  std::string waits;  // reason why it takes effect only after a reset; empty: it takes effect at once
  int count = 1;      // of numbers
  std::array<double, 3> value{};
  bool is_changed = false;            // an override that the scene was not opened with
  std::optional<std::string> opened;  // value of the override that it was opened with
};
using ParameterList = std::vector<Parameter>;

/// Parameters of the bodies, tools and world of a scene; those with immediate effect come first. `opened`:
/// overrides that the scene was opened with.
ParameterList list_parameters(const Scene& scene, const std::vector<std::string>& opened = {});
/// Body, tool, incision or world of a parameter: "body.torso".
std::string owner_of(const Parameter& parameter);
/// Unit and range: "N/m, 0 or more".
std::string unit_and_range(const Parameter& parameter);

/// Value in the syntax of --set.
std::string value_text(const Parameter& parameter);
/// Clamps a value to the scene's limits; for limits that are not ends of a slider.
double limited(const Allowed& allowed, double value);

}  // namespace turgor
