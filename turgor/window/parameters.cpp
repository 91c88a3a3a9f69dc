#include "turgor/window/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/scene/scene_edit.hpp"

namespace turgor {

namespace {

/// Parses numbers of "3", "[0.4, 10]", "[0, 0, -9.81]" or "`[1, 0, 0]`"; returns their count, 0 for anything
/// else.
int numbers_of(std::string text, std::array<double, 3>& numbers) {
  if (std::count(text.begin(), text.end(), '[') > 1) return 0;  // an array of arrays
  std::erase_if(text, [](char c) { return c == '`' || c == '[' || c == ']' || c == '_'; });
  int count = 0;
  const char* at = text.c_str();
  while (*at) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end == at || count == 3 || !std::isfinite(number)) return 0;
    numbers[std::size_t(count++)] = number;
    at = end + std::strspn(end, ", \t");
  }
  return count;
}

bool is_offered(const SceneKey& key) {
  const bool is_of_no_layer = key.path.find(".layers.") != key.path.npos;  // the scene has no layers
  return !key.path.starts_with("output.") && key.path.find("NAME") == key.path.npos && !is_of_no_layer;
}

}  // namespace

ParameterList list_parameters(const Scene& scene, const std::vector<std::string>& opened) {
  ParameterList list;
  for (SceneKey& key : scene_keys(scene.text, scene.file)) {
    if (!is_offered(key)) continue;
    const std::string given = scene_value(scene, key.path), text = given.empty() ? key.fallback : given;
    Parameter parameter{
        .key = key, .waits = why_not_live(scene, key), .opened = override_of(opened, key.path)};
    parameter.is_changed = override_of(scene.overrides, key.path) != parameter.opened;
    parameter.count = numbers_of(text, parameter.value);
    if (parameter.count == 0) continue;
    list.push_back(std::move(parameter));
  }
  std::stable_partition(list.begin(), list.end(), [](const Parameter& one) { return one.waits.empty(); });
  return list;
}

std::string owner_of(const Parameter& parameter) {
  const std::string& path = parameter.key.path;
  const std::size_t first = path.find('.');
  if (first == path.npos || path.starts_with("world.")) return path.substr(0, first);
  return path.substr(0, path.find('.', first + 1));
}

std::string unit_and_range(const Parameter& parameter) {
  std::string text = parameter.key.unit;
  const Allowed& allowed = parameter.key.allowed;
  const bool is_bounded = allowed.low > -kLargestNumber || allowed.high < kLargestNumber;
  std::string limits = "any number";
  if (is_bounded && allowed.high < kLargestNumber)
    limits = limits_text(allowed);
  else if (is_bounded)
    limits = allowed.low > 0 && allowed.low < 1e-6 ? "above 0" : fmt::format("{:g} or more", allowed.low);
  return text.empty() ? limits : text + ", " + limits;
}

std::string value_text(const Parameter& parameter) {
  const auto& v = parameter.value;
  const auto number = [&](double x) {
    return parameter.key.is_whole ? fmt::format("{}", std::lround(x)) : fmt::format("{:.6g}", x);
  };
  if (parameter.count == 1) return number(v[0]);
  std::string text;
  for (int n = 0; n < parameter.count; n++) text += (n ? ", " : "[") + number(v[std::size_t(n)]);
  return text + "]";
}

double limited(const Allowed& allowed, double value) {
  const double clamped = std::clamp(value, allowed.low, allowed.high);
  if (!allowed.open || (clamped > allowed.low && clamped < allowed.high)) return clamped;
  return clamped <= allowed.low ? std::nextafter(float(allowed.low), 1e30f)
                                : std::nextafter(float(allowed.high), -1e30f);
}

}  // namespace turgor
