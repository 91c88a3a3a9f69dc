#include "turgor/sim/scene/markups.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/input_file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMostBytes = std::uintmax_t(16) << 20;  // of a file
constexpr std::size_t kMostPoints = 10000;
constexpr double kFarthest = 100;  // coordinate [m]

/// "a number", "the text x".
std::string kind_of(const json& value) {
  if (value.is_string()) return fmt::format("\"{}\"", value.get<std::string>().substr(0, 40));
  if (value.is_number() || value.is_boolean()) return value.dump();
  return value.is_null() ? "nothing" : value.is_array() ? "a list" : "an object";
}

/// Member of an object; null if it is missing.
const json& member(const json& object, const char* key) {
  static const json kNone;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : kNone;
}

bool is_path(const json& markup) {
  const json& type = member(markup, "type");
  return type == "Line" || type == "Curve" || type == "ClosedCurve";
}

/// Factors from the file's coordinates to LPS in meters.
Result<Vec3d> scale_of(const json& markup, const std::string& where) {
  const json& system = member(markup, "coordinateSystem");
  const bool is_lps = system.is_null() || system == "LPS";
  const bool is_ras = system == "RAS";
  if (!is_lps && !is_ras)
    return Error{
        fmt::format("{}.coordinateSystem: expected \"LPS\" or \"RAS\", found {}", where, kind_of(system))};
  const json& units = member(markup, "coordinateUnits");  // a text, or the list of a DICOM code
  const json& unit = units.is_array() && !units.empty() ? units[0] : units;
  const double meters = unit.is_null() || unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : unit == "m" ? 1.0 : 0;
  if (meters == 0)
    return Error{
        fmt::format("{}.coordinateUnits: expected \"mm\", \"cm\" or \"m\", found {}", where, kind_of(unit))};
  const double flip = is_ras ? -meters : meters;
  return Vec3d{flip, flip, meters};
}

/// True if Slicer has a position for the point, and not only an entry in the list.
bool is_defined(const json& point) {
  const json& status = member(point, "positionStatus");
  return status.is_null() || status == "defined";
}

Result<Vec3d> position_of(const json& point, const std::string& where) {
  const json& position = member(point, "position");
  const auto is_number = [](const json& x) { return x.is_number() && std::isfinite(x.get<double>()); };
  if (!position.is_array() || position.size() != 3 ||
      !std::all_of(position.begin(), position.end(), is_number))
    return Error{fmt::format("{}.position: expected [x, y, z], found {}", where, kind_of(position))};
  return Vec3d{position[0].get<double>(), position[1].get<double>(), position[2].get<double>()};
}

Result<Markup> markup_of(const json& markup, const std::string& where) {
  const Result<Vec3d> scale = scale_of(markup, where);
  if (!scale) return scale.error();
  const json& points = member(markup, "controlPoints");
  if (!points.is_array() || points.size() > kMostPoints)
    return Error{fmt::format("{}.controlPoints: expected a list of at most {} points, found {}", where,
                             kMostPoints, kind_of(points))};

  // positions, without repetitions
  Markup read{.points = {}, .is_line = member(markup, "type") == "Line"};
  for (std::size_t n = 0; n < points.size(); n++) {
    if (!is_defined(points[n])) continue;
    const std::string at = fmt::format("{}.controlPoints[{}]", where, n);
    const Result<Vec3d> position = position_of(points[n], at);
    if (!position) return position.error();
    const Vec3d x = hadamard(*position, *scale);
    if (!(std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}) <= kFarthest))
      return Error{fmt::format("{}.position: expected at most {} m, found another unit", at, kFarthest)};
    if (read.points.empty() || !(read.points.back() == x)) read.points.push_back(x);
  }

  // closed curves end at their first point
  const bool is_closed = member(markup, "type") == "ClosedCurve";
  if (is_closed && read.points.size() > 1 && !(read.points.front() == read.points.back()))
    read.points.push_back(read.points.front());
  const std::size_t fewest = is_closed ? 4 : 2;
  if (read.points.size() < fewest)
    return Error{fmt::format("{}.controlPoints: expected {} points or more at different positions, found {}",
                             where, is_closed ? 3 : 2,
                             read.points.size() - (is_closed && read.points.size() > 1))};
  if (read.is_line && read.points.size() != 2)
    return Error{fmt::format("{}.controlPoints: expected the 2 points of a line, found {}", where,
                             read.points.size())};
  return read;
}

}  // namespace

bool is_markups_file(const fs::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name.ends_with(".mrk.json");
}

Result<Markup> parse_markup(std::string_view text, const fs::path& file) {
  const auto fail = [&file](const std::string& what) {
    return Error{fmt::format("{}: {}", file.string(), what)};
  };
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) return fail("expected JSON of 3D Slicer's Markups, found other text");
  const json& markups = member(root, "markups");
  if (!markups.is_array()) return fail("markups: expected a list, found " + kind_of(markups));

  // the only path
  const auto count = std::count_if(markups.begin(), markups.end(), is_path);
  if (count != 1)
    return fail(fmt::format("markups: expected one Line, Curve or ClosedCurve, found {}", count));
  const auto found = std::find_if(markups.begin(), markups.end(), is_path);
  Result<Markup> read = markup_of(*found, fmt::format("markups[{}]", found - markups.begin()));
  return read ? read : fail(read.error().message);
}

Result<Markup> read_markup(const fs::path& file) {
  if (const Status sound = io::check_input(file); !sound) return sound.error();
  std::error_code ignored;
  if (const std::uintmax_t bytes = fs::file_size(file, ignored); bytes > kMostBytes)
    return Error{
        fmt::format("{}: expected at most {} bytes of markups, found {}", file.string(), kMostBytes, bytes)};
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  return parse_markup(*text, file);
}

}  // namespace turgor
