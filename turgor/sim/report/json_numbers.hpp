// Numbers in reports.
#pragma once

#include <cmath>
#include <initializer_list>

#include <nlohmann/json.hpp>

#include "turgor/core/vec.hpp"

namespace turgor {

using Json = nlohmann::ordered_json;

constexpr double kMm = 1e3;

/// Rounded to six significant digits.
inline double rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return std::isfinite(value) ? 0.0 : value;
  const double unit = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(unit) ? std::round(value * unit) / unit : value;
}

inline Json numbers(std::initializer_list<double> values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(rounded(value));
  return array;
}

}  // namespace turgor
