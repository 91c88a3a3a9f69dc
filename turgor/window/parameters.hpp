// Adjustable keys of a scene with their units, limits, descriptions and values.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_key.hpp"

namespace turgor {

/// A key with one or three numbers.
struct Parameter {
  SceneKey key;
  std::string waits;  // reason why it takes effect only after a reset; empty: it takes effect at once
  int count = 1;      // of numbers
  std::array<double, 3> value{};
};
using ParameterList = std::vector<Parameter>;

/// Parameters of the bodies, tools and world of a scene; those with immediate effect come first.
ParameterList list_parameters(const Scene& scene);

/// Value in the syntax of --set.
std::string value_text(const Parameter& parameter);
/// Clamps a value to the scene's limits; for limits that are not ends of a slider.
double limited(const Allowed& allowed, double value);

}  // namespace turgor
