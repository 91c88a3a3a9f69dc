// Doubt about the unit of a mesh file. Most mesh files do not state theirs, and a liver in millimeters would
// be 200 m wide.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

constexpr double kLargestMesh = 2, kSmallestMesh = 1e-3;  // largest extents that cause no question [m]

/// Kind of object in a mesh file. Its usual size decides which unit is suggested.
enum class Meshed : std::uint8_t { kOrgan, kGarment };

/// "6.4 m wide: is it in cm? scale = 0.01" for a largest extent [m] that no organ, garment or tool has; empty
/// for others. A garment whose size fits no unit gets the scale of a usual one.
std::string unit_question(double size, Meshed meshed = Meshed::kOrgan);

/// Largest extent of points along an axis [m].
template <class T>
double largest_extent(const std::vector<Vec<T>>& points) {
  if (points.empty()) return 0;
  Vec<T> low = points.front(), high = low;
  for (const Vec<T> x : points) low = min(low, x), high = max(high, x);
  return double(std::max({high.x - low.x, high.y - low.y, high.z - low.z}));
}

/// Error: the question about a file whose scale was not given.
template <class T>
Status check_unit(const std::filesystem::path& file, const std::vector<Vec<T>>& points, bool is_scale_given,
                  Meshed meshed = Meshed::kOrgan) {
  const std::string question = is_scale_given ? std::string() : unit_question(largest_extent(points), meshed);
  if (question.empty()) return Done{};
  return Error{file.string() + ": " + question + " (scale = 1 if it is in meters)"};
}

}  // namespace turgor
