// Grid of an NRRD file, from "space", "space directions" and "space origin", or from "spacings" and "axis
// mins" along the patient's axes. Lengths are in millimeters.
#include "turgor/io/volume/nrrd_grid.hpp"

#include <algorithm>
#include <array>
#include <map>

#include <fmt/format.h>

#include "turgor/io/files/file_cursor.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

Error unexpected(const fs::path& path, const TextFields& fields, const std::string& key,
                 std::string_view expected) {
  return {fmt::format("{}: \"{}: {}\"; expected {}", path.string(), key, fields.get(key), expected)};
}

/// Signs that convert the axes of a space to left, posterior, superior. A right-handed space without
/// anatomical names is taken as LPS. A left-handed one would mirror the patient.
Result<Vec3d> signs_to_lps(const fs::path& path, const TextFields& fields) {
  static const std::map<std::string, Vec3d, std::less<>> kSigns = {{"left-posterior-superior", {1, 1, 1}},
                                                                   {"lps", {1, 1, 1}},
                                                                   {"right-anterior-superior", {-1, -1, 1}},
                                                                   {"ras", {-1, -1, 1}},
                                                                   {"left-anterior-superior", {1, -1, 1}},
                                                                   {"las", {1, -1, 1}},
                                                                   {"scanner-xyz", {1, 1, 1}},
                                                                   {"3d-right-handed", {1, 1, 1}}};
  if (!fields.has("space") && fields.get("space dimension") == "3") return Vec3d{1, 1, 1};
  if (!fields.has("space"))
    return unexpected(path, fields, "space", "a space, because the file has directions or an origin");
  const auto found = kSigns.find(lower_case(fields.get("space")));
  if (found == kSigns.end())
    return unexpected(path, fields, "space",
                      "left-posterior-superior, right-anterior-superior or left-anterior-superior");
  return found->second;
}

Result<Vec3d> along_axes(const fs::path& path, const TextFields& fields, const std::string& key) {
  const std::vector<double> numbers = real_numbers(fields.get(key));
  if (numbers.size() != 3) return unexpected(path, fields, key, "3 finite numbers");
  return Vec3d{numbers[0], numbers[1], numbers[2]};
}

Status check_units(const fs::path& path, const TextFields& fields) {
  for (const char* key : {"units", "space units"}) {
    std::string text = lower_case(fields.get(key));
    std::replace(text.begin(), text.end(), '"', ' ');
    for (const std::string_view unit : words(text))
      if (!is_millimeter(unit)) return unexpected(path, fields, key, "millimeters (\"mm\")");
  }
  return Done{};
}

/// Directions of the three spatial axes, without the one of components.
std::vector<Vec3d> directions_in_space(const TextFields& fields) {
  const auto written = nrrd_vectors(fields.get("space directions"));
  std::vector<Vec3d> directions;
  for (const std::optional<Vec3d>& direction : written)
    if (direction) directions.push_back(*direction);
  const bool is_one_an_axis = written.size() == whole_numbers(fields.get("sizes")).size();
  return is_one_an_axis ? directions : std::vector<Vec3d>{};
}

Status place_in_space(const fs::path& path, const TextFields& fields, Grid& grid) {
  const Result<Vec3d> signs = signs_to_lps(path, fields);
  if (!signs) return signs.error();
  for (const char* key : {"spacings", "axis mins", "axis maxs"})
    if (fields.has(key))
      return unexpected(path, fields, key, "\"space directions\" alone in a file with a space");
  if (fields.has("space origin")) {
    const auto origin = nrrd_vectors(fields.get("space origin"));
    if (origin.size() != 1 || !origin[0])
      return unexpected(path, fields, "space origin", "3 finite numbers: (x,y,z)");
    grid.origin = hadamard(*signs, *origin[0]) * 1e-3;
  }
  if (!fields.has("space directions")) return Done{};
  const std::vector<Vec3d> directions = directions_in_space(fields);
  if (directions.size() != 3)
    return unexpected(path, fields, "space directions", "3 directions of finite numbers: (x,y,z)");
  for (int axis = 0; axis < 3; axis++) {
    const Vec3d step = hadamard(*signs, directions[std::size_t(axis)]);
    grid.spacing[axis] = norm(step) * 1e-3;
    grid.axes.column[axis] = step / norm(step);
  }
  return Done{};
}

/// "axis mins" are the lower ends of the first samples, or their centers with node centering.
Status read_grid_along_axes(const fs::path& path, const TextFields& fields, Grid& grid) {
  if (!fields.has("spacings")) {
    for (const char* key : {"axis mins", "axis maxs"})
      if (fields.has(key)) return unexpected(path, fields, key, "\"spacings\" with it");
    return Done{};
  }
  const Result<Vec3d> spacing = along_axes(path, fields, "spacings");
  if (!spacing) return spacing.error();
  grid.spacing = *spacing * 1e-3;
  if (!fields.has("axis mins")) return Done{};
  const Result<Vec3d> least = along_axes(path, fields, "axis mins");
  if (!least) return least.error();
  const std::string text = lower_case(fields.get("centerings"));
  const std::vector<std::string_view> centerings = words(text);
  for (int axis = 0; axis < 3; axis++) {
    const bool is_node = centerings.size() == 3 && centerings[std::size_t(axis)] == "node";
    grid.origin[axis] = ((*least)[axis] + (is_node ? 0 : (*spacing)[axis] / 2)) * 1e-3;
  }
  return Done{};
}

}  // namespace

std::vector<std::optional<Vec3d>> nrrd_vectors(std::string_view text) {
  std::vector<std::optional<Vec3d>> vectors;
  for (std::string rest = trimmed(text); !rest.empty();) {
    if (rest.starts_with("none")) {
      vectors.emplace_back();
      rest = trimmed(rest.substr(4));
      continue;
    }
    const std::size_t end = rest.find(')');
    if (!rest.starts_with('(') || end == rest.npos) return {};
    std::string inside = rest.substr(1, end - 1);
    std::replace(inside.begin(), inside.end(), ',', ' ');
    const std::vector<double> numbers = real_numbers(inside);
    if (numbers.size() != 3) return {};
    vectors.emplace_back(Vec3d{numbers[0], numbers[1], numbers[2]});
    rest = trimmed(rest.substr(end + 1));
  }
  return vectors;
}

Status read_nrrd_grid(const fs::path& path, const TextFields& fields, Grid& grid) {
  grid.spacing = Vec3d{1, 1, 1} * 1e-3;
  grid.axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (Status units = check_units(path, fields); !units) return units;
  const bool is_in_space = fields.has("space") || fields.has("space dimension") ||
                           fields.has("space directions") || fields.has("space origin");
  return is_in_space ? place_in_space(path, fields, grid) : read_grid_along_axes(path, fields, grid);
}

}  // namespace turgor::io
