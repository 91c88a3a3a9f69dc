#include "turgor/sim/tools/tool_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/io/files/number_table.hpp"
#include "turgor/sim/tools/column_units.hpp"

namespace turgor {

namespace {

Error row_error(std::size_t row, const std::string& what) {
  return {fmt::format("row {} of the path: {}", row + 1, what)};
}

/// Slope of a monotone cubic at a row (Fritsch and Butland 1984): weighted harmonic mean of the slopes on
/// both sides, zero if they have opposite signs.
double slope_at(double h0, double d0, double h1, double d1) {
  if (!(d0 * d1 > 0)) return 0;
  TURGOR_CHECK(h0 > 0 && h1 > 0, "the times of a path ascend");
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

double slope_of_row(const std::vector<PathRow>& rows, std::size_t r, int axis) {
  if (r == 0 || r + 1 == rows.size()) return 0;  // the tool starts and ends at rest
  const double h0 = rows[r].time - rows[r - 1].time, h1 = rows[r + 1].time - rows[r].time;
  return slope_at(h0, (rows[r].position[axis] - rows[r - 1].position[axis]) / h0, h1,
                  (rows[r + 1].position[axis] - rows[r].position[axis]) / h1);
}

Vec3d smooth_position(const std::vector<PathRow>& rows, std::size_t r, double s) {
  TURGOR_CHECK(r + 1 < rows.size(), "a position lies between two rows");
  const double h = rows[r + 1].time - rows[r].time, s2 = s * s, s3 = s2 * s;
  Vec3d x;
  for (int axis = 0; axis < 3; axis++)
    x[axis] =
        (2 * s3 - 3 * s2 + 1) * rows[r].position[axis] + (s3 - 2 * s2 + s) * h * slope_of_row(rows, r, axis) +
        (3 * s2 - 2 * s3) * rows[r + 1].position[axis] + (s3 - s2) * h * slope_of_row(rows, r + 1, axis);
  return x;
}

/// Scales of the columns t, x, y and z to seconds and meters, from their names in the first line.
Result<std::array<double, 4>> path_scales(const std::filesystem::path& file) {
  std::array<double, 4> scales{1, 1, 1, 1};
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  for (std::size_t c = 0; c < std::min(names->size(), scales.size()); c++) {
    const Result<ColumnUnit> unit =
        column_unit(file, (*names)[c], c == 0 ? ColumnKind::kTime : ColumnKind::kLength);
    if (!unit) return unit.error();
    scales[c] = unit->size;
  }
  return scales;
}

}  // namespace

Result<std::vector<PathRow>> path_rows(const std::vector<std::vector<double>>& rows) {
  std::vector<PathRow> path;
  for (std::size_t r = 0; r < rows.size(); r++) {
    // checks
    const std::vector<double>& v = rows[r];
    if (v.size() != 4 && v.size() != 5 && v.size() != 9)
      return row_error(r, fmt::format("expected t, x, y, z and at most hold and a quaternion w, x, y, z "
                                      "(4, 5 or 9 numbers), found {} numbers",
                                      v.size()));
    for (const double value : v)
      if (!std::isfinite(value)) return row_error(r, fmt::format("expected numbers, found {}", value));
    if (r > 0 && v[0] <= path.back().time)
      return row_error(r, fmt::format("expected a time after that of the previous row, {} s, found {} s",
                                      path.back().time, v[0]));

    // row
    PathRow row{.time = v[0],
                .position = {v[1], v[2], v[3]},
                .hold = v.size() > 4 && v[4] != 0,
                .orientation = {1, 0, 0, 0}};
    if (v.size() == 9) {
      row.orientation = {v[5], v[6], v[7], v[8]};
      if (!(dot(row.orientation, row.orientation) > 0))
        return row_error(r, "expected a quaternion, found four zeros");
      row.orientation = normalized(row.orientation);
    }
    path.push_back(row);
  }
  if (path.empty()) return Error{"expected a path of at least one row, t, x, y, z, found none"};
  return path;
}

Result<std::vector<PathRow>> read_path_rows(const std::filesystem::path& file) {
  const Result<std::vector<NumberRow>> table = read_number_table(file, "numbers t, x, y, z");
  if (!table) return table.error();
  std::vector<std::vector<double>> rows;
  const Result<std::array<double, 4>> scales = path_scales(file);
  if (!scales) return scales.error();
  for (const NumberRow& row : *table) {
    rows.push_back(row.values);
    for (std::size_t c = 0; c < std::min(rows.back().size(), scales->size()); c++)
      rows.back()[c] *= (*scales)[c];
  }
  Result<std::vector<PathRow>> path = path_rows(rows);
  if (!path) return Error{fmt::format("{}: {}", file.string(), path.error().message)};
  return path;
}

PathRow path_at(const ToolPath& path, double time) {
  TURGOR_ASSERT(!path.rows.empty(), "a path has at least one row");
  // last row at or before the time
  const std::vector<PathRow>& rows = path.rows;
  const auto later = std::upper_bound(rows.begin(), rows.end(), time,
                                      [](double t, const PathRow& row) { return t < row.time; });
  PathRow now = later == rows.begin() ? rows.front() : *(later - 1);
  now.time = time;
  // outside the path, hold the end pose
  if (later == rows.begin() || later == rows.end()) return now;
  // interpolate between neighboring rows
  const std::size_t r = std::size_t(later - rows.begin()) - 1;
  TURGOR_CHECK(rows[r + 1].time > rows[r].time, "the times of a path ascend");
  const double s = (time - rows[r].time) / (rows[r + 1].time - rows[r].time);
  now.position =
      path.smooth ? smooth_position(rows, r, s) : rows[r].position * (1 - s) + rows[r + 1].position * s;
  now.orientation = between(rows[r].orientation, rows[r + 1].orientation, s);
  return now;
}

Quaternion turned_to(Vec3d z) {
  TURGOR_CHECK(is_unit(z), "an axis is a unit vector");
  if (z.z <= -1 + 1e-12) return {0, 1, 0, 0};
  return normalized(Quaternion{1 + z.z, -z.y, z.x, 0});
}

}  // namespace turgor
