// The keys of a scene as a person turns them: with their unit, their limits, what they mean and what they
// are.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_key.hpp"

namespace turgor {

/// A key that is a number or three.
struct Parameter {
  SceneKey key;
  std::string waits;  // why it acts only when the world is made anew; empty: it acts at once
  int count = 1;      // of numbers
  std::array<double, 3> value{};
};
using ParameterList = std::vector<Parameter>;

/// Those of the bodies, tools and the world of a scene; those that act at once come first.
ParameterList list_parameters(const Scene& scene);

/// As --set takes it.
std::string value_text(const Parameter& parameter);
/// What a value is held to, where the scene's limits are no ends of a slider.
double limited(const Allowed& allowed, double value);

}  // namespace turgor
