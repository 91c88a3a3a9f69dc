#include "turgor/sim/tools/hand.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

enum Column : std::size_t { kTime, kX, kY, kZ, kAxes, kGrip = kAxes + 9, kHold, kColumns };

const std::array<const char*, kColumns> kNames{"time_s",   "x_m",      "y_m",      "z_m",      "axis_x_x",
                                               "axis_x_y", "axis_x_z", "axis_y_x", "axis_y_y", "axis_y_z",
                                               "axis_z_x", "axis_z_y", "axis_z_z", "grip",     "hold"};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t\r"), last = cell.find_last_not_of(" \t\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

/// Index of each column in a row; -1 = missing.
struct Header {
  std::array<int, kColumns> at{};
  int tool = -1;
};

Result<Header> read_header(const std::string& line) {
  const std::vector<std::string> cells = cells_of(line);
  const auto find = [&](const std::string& name) {
    const auto found = std::find(cells.begin(), cells.end(), name);
    return found == cells.end() ? -1 : int(found - cells.begin());
  };
  Header header;
  for (std::size_t c = 0; c < kColumns; c++) header.at[c] = find(kNames[c]);
  header.tool = find("tool");
  const auto axes = header.at.begin() + kAxes;
  const auto axis_columns = std::count_if(axes, axes + 9, [](int at) { return at >= 0; });
  for (std::size_t c = 0; c < kAxes; c++)
    if (header.at[c] < 0)
      return Error{fmt::format("expected a first line with column names, among them {}, found \"{:.60}\"",
                               kNames[c], line)};
  if (axis_columns != 0 && axis_columns != 9)
    return Error{
        fmt::format("expected all of axis_x_x … axis_z_z or none, found {} of the nine", axis_columns)};
  return header;
}

/// The number, or NAN.
double number_of(const std::string& cell) {
  double value = NAN;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  return error == std::errc() && stop == end ? value : NAN;
}

contact::ToolCommand command_of(const std::array<double, kColumns>& v) {
  const auto axis = [&](std::size_t a) {
    return Vec3d{v[kAxes + 3 * a], v[kAxes + 3 * a + 1], v[kAxes + 3 * a + 2]};
  };
  return {.pose = {{v[kX], v[kY], v[kZ]}, {{axis(0), axis(1), axis(2)}}},
          .grip = v[kGrip],
          .hold = v[kHold] != 0};
}

Result<HandRow> read_row(const Header& header, const std::vector<std::string>& cells) {
  // defaults for missing columns: zeros and identity axes
  std::array<double, kColumns> values{};
  for (const std::size_t diagonal : {0, 4, 8}) values[kAxes + diagonal] = 1;
  // parse the cells
  for (std::size_t c = 0; c < kColumns; c++) {
    if (header.at[c] < 0) continue;
    const auto cell = std::size_t(header.at[c]);
    const std::string text = cell < cells.size() ? cells[cell] : "";
    values[c] = number_of(text);
    if (!std::isfinite(values[c]))
      return Error{fmt::format("expected a number for {}, found \"{:.40}\"", kNames[c], text)};
  }
  // check axes and grip
  const HandRow row{values[kTime], command_of(values)};
  if (!contact::is_valid(row.command.pose))
    return Error{"expected orthonormal right-handed axes, found others"};
  if (!(row.command.grip >= 0 && row.command.grip <= 1))
    return Error{fmt::format("expected a grip from 0 (open) to 1 (closed), found {}", row.command.grip)};
  return row;
}

/// Tool of a row; `fallback` without a column `tool`.
std::string tool_of(const Header& header, const std::vector<std::string>& cells,
                    const std::string& fallback) {
  if (header.tool < 0) return fallback;
  return std::size_t(header.tool) < cells.size() ? cells[std::size_t(header.tool)] : "";
}

Status check_next(const std::vector<HandRow>& rows, const HandRow& row) {
  if (!rows.empty() && row.time <= rows.back().time)
    return Error{fmt::format("expected a time after that of the previous row, {} s, found {} s",
                             rows.back().time, row.time)};
  if (rows.size() == kMostHandRows)
    return Error{fmt::format("expected at most {} rows, found more", kMostHandRows)};
  return Done{};
}

std::string in_line(const std::filesystem::path& file, int line, const std::string& what) {
  return fmt::format("{}:{}: {}", file.string(), line, what);
}

/// Quaternion w, x, y, z of a rotation matrix (Shepperd 1978).
std::array<double, 4> quaternion_of(const Mat3d& m) {
  // pivot on the largest of trace and diagonal, which avoids cancellation
  const auto& [x, y, z] = m.column;
  const double trace = x.x + y.y + z.z;
  std::array<double, 4> q{};
  if (trace >= std::max({x.x, y.y, z.z}))
    q = {1 + trace, y.z - z.y, z.x - x.z, x.y - y.x};
  else if (x.x >= std::max(y.y, z.z))
    q = {y.z - z.y, 1 + 2 * x.x - trace, x.y + y.x, z.x + x.z};
  else if (y.y >= z.z)
    q = {z.x - x.z, x.y + y.x, 1 + 2 * y.y - trace, y.z + z.y};
  else
    q = {x.y - y.x, z.x + x.z, y.z + z.y, 1 + 2 * z.z - trace};
  // normalize
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  TURGOR_CHECK(length > 0, "a rotation matrix has a quaternion");
  for (double& component : q) component /= length;
  return q;
}

}  // namespace

std::vector<std::string> hand_columns() { return {kNames.begin(), kNames.end()}; }

Result<std::vector<HandRow>> read_hand(const std::filesystem::path& file, const std::string& tool) {
  // header
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  std::istringstream lines(*text);
  std::string line;
  std::getline(lines, line);
  const Result<Header> header = read_header(line);
  if (!header) return Error{in_line(file, 1, header.error().message)};

  // rows of this tool
  std::vector<HandRow> rows;
  std::set<std::string> others;
  for (int number = 2; std::getline(lines, line); number++) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty())) continue;
    if (const std::string name = tool_of(*header, cells, tool); name != tool) {
      others.insert(name);
      continue;
    }
    const Result<HandRow> row = read_row(*header, cells);
    if (!row) return Error{in_line(file, number, row.error().message)};
    if (const Status status = check_next(rows, *row); !status)
      return Error{in_line(file, number, status.error().message)};
    rows.push_back(*row);
  }

  // errors
  if (!rows.empty()) return rows;
  return Error{others.empty() ? fmt::format("{}: expected a row per tick, found none", file.string())
                              : fmt::format("{}: expected rows of the tool {}, found those of {}",
                                            file.string(), tool, fmt::join(others, ", "))};
}

const HandRow& hand_at(const std::vector<HandRow>& hand, double time) {
  TURGOR_ASSERT(!hand.empty(), "a hand has at least one row");
  const auto later = std::upper_bound(hand.begin(), hand.end(), time,
                                      [](double t, const HandRow& row) { return t < row.time; });
  return later == hand.begin() ? hand.front() : *(later - 1);
}

ToolPath path_of(const std::vector<HandRow>& hand) {
  TURGOR_CHECK(!hand.empty(), "a hand has at least one row");
  ToolPath path;
  for (const auto& [time, command] : hand)
    path.rows.push_back({.time = time,
                         .position = command.pose.position,
                         .hold = command.hold,
                         .orientation = quaternion_of(command.pose.axes)});
  return path;
}

}  // namespace turgor
