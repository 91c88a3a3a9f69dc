#include "turgor/sim/tools/load_texture.hpp"

#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "turgor/io/files/number_table.hpp"

namespace turgor {

namespace {

using Map = std::shared_ptr<const contact::HeightMap>;

/// Map of the scene's file; null without one.
Result<Map> load_height_map(const HeightMapScene& scene) {
  constexpr std::size_t kMost = 4'000'000;
  constexpr double kHighest = 1e-3;  // [m]
  if (scene.file.empty()) return Map();
  const std::string file = scene.file.string();
  const Result<std::vector<NumberRow>> rows = read_number_table(scene.file, "numbers: heights");
  if (!rows) return rows.error();

  // rows of the same length
  const std::size_t columns = rows->front().values.size();
  std::vector<double> height;
  for (const NumberRow& row : *rows) {
    if (row.values.size() != columns)
      return Error{fmt::format("{}:{}: expected {} heights as in the first row, found {}", file, row.line,
                               columns, row.values.size())};
    for (const double h : row.values) height.push_back(h * scene.scale);
    if (height.size() > kMost)
      return Error{fmt::format("{}: expected at most {} heights, found more", file, kMost)};
  }
  if (height.size() < 2) return Error{fmt::format("{}: expected at least two heights, found one", file)};

  // a texture is flat
  const double mean = std::accumulate(height.begin(), height.end(), 0.0) / double(height.size());
  for (const double h : height)
    if (!(std::abs(h - mean) <= kHighest))
      return Error{fmt::format(
          "{}: expected heights within 1 mm of their mean, found {:.3g} mm from it: heights are in "
          "meters, unless texture.scale says otherwise",
          file, 1e3 * (h - mean))};
  const int row_count = int(height.size() / columns);
  return std::make_shared<const contact::HeightMap>(
      contact::make_height_map(int(columns), row_count, scene.spacing, std::move(height)));
}

}  // namespace

Result<contact::Texture> load_texture(const TextureScene& scene) {
  Result<Map> map = load_height_map(scene.height_map);
  if (!map) return map.error();
  return contact::Texture{scene.waves, std::move(*map)};
}

}  // namespace turgor
