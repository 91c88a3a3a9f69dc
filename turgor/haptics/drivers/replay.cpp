#include "turgor/haptics/drivers/replay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/drivers/readings.hpp"
#include "turgor/haptics/rotation.hpp"
#include "turgor/io/files/number_table.hpp"

namespace turgor::haptics {

namespace {

enum Column { kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kGrip, kButtons, kColumnCount };
constexpr std::string_view kNames[kColumnCount] = {"time_s", "x_m", "y_m", "z_m",  "qw",
                                                   "qx",     "qy",  "qz",  "grip", "buttons"};
constexpr const char* kExpected = "time_s, x_m, y_m, z_m and, optionally, qw, qx, qy, qz, grip, buttons";

/// Index of each column in a row; -1 = absent.
using ColumnIndices = std::array<int, kColumnCount>;

Result<ColumnIndices> column_indices(const std::vector<std::string>& names) {
  // known columns, each at most once
  ColumnIndices columns;
  columns.fill(-1);
  for (std::size_t n = 0; n < names.size(); n++) {
    const auto known = std::find(std::begin(kNames), std::end(kNames), names[n]);
    if (known == std::end(kNames))
      return Error{fmt::format("expected columns {}; found \"{:.60}\"", kExpected, names[n])};
    int& index = columns[std::size_t(known - std::begin(kNames))];
    if (index >= 0) return Error{fmt::format("the column {} is given twice", names[n])};
    index = int(n);
  }
  // required columns
  for (const int needed : {kTime, kX, kY, kZ})
    if (columns[std::size_t(needed)] < 0)
      return Error{fmt::format("expected columns {}; {} is missing", kExpected, kNames[needed])};
  const auto count =
      std::count_if(columns.begin() + kQw, columns.begin() + kQz + 1, [](int p) { return p >= 0; });
  if (count != 0 && count != 4) return Error{"expected all of qw, qx, qy, qz or none of them"};
  return columns;
}

/// Fault of a row; empty when valid.
std::string fault_of(const PoseRow& row, const std::vector<PoseRow>& before, double buttons) {
  // time ascends
  if (!before.empty() && row.time <= before.back().time)
    return fmt::format("expected a time after {} s, found {} s", before.back().time, row.time);
  // pose
  if (!(norm(row.position) < 1))
    return fmt::format("expected a position within 1 m of the center, in meters, found {}, {}, {}",
                       row.position.x, row.position.y, row.position.z);
  const double length = std::sqrt(dot(row.orientation, row.orientation));
  if (std::abs(length - 1) > 0.01)
    return fmt::format("expected a quaternion qw, qx, qy, qz of length 1, found one of length {:.3g}",
                       length);
  // grip and buttons
  if (row.grip < 0 || row.grip > 1) return fmt::format("expected a grip from 0 to 1, found {}", row.grip);
  if (buttons < 0 || buttons > 0xffffffff || buttons != std::floor(buttons))
    return fmt::format("expected buttons as a whole number, a bit each, found {}", buttons);
  return "";
}

/// Row from its values. Error: the fault, given the rows before.
Result<PoseRow> row_of(const std::vector<double>& values, const ColumnIndices& columns,
                       const std::vector<PoseRow>& before) {
  const auto value = [&](Column column, double otherwise) {
    return columns[column] < 0 ? otherwise : values[std::size_t(columns[column])];
  };
  TURGOR_CHECK(std::all_of(columns.begin(), columns.end(), [&](int c) { return c < int(values.size()); }),
               "every column is in the row");
  PoseRow row{.time = value(kTime, 0),
              .position = {value(kX, 0), value(kY, 0), value(kZ, 0)},
              .orientation = {value(kQw, 1), value(kQx, 0), value(kQy, 0), value(kQz, 0)},
              .has_orientation = columns[kQw] >= 0,
              .grip = value(kGrip, 0)};
  const double buttons = value(kButtons, 0);
  if (const std::string fault = fault_of(row, before, buttons); !fault.empty()) return Error{fault};
  row.orientation = normalized(row.orientation);
  row.buttons = std::uint32_t(buttons);
  return row;
}

DeviceInput resting(const PoseRow& row) {
  return {.pose = {row.position, axes_of(row.orientation)}, .grip = row.grip, .buttons = row.buttons};
}

}  // namespace

Result<std::vector<PoseRow>> read_poses(const std::filesystem::path& file) {
  // columns
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  const Result<ColumnIndices> columns = column_indices(*names);
  if (!columns) return Error{fmt::format("{}: {}", file.string(), columns.error().message)};
  // rows
  const Result<std::vector<NumberRow>> table = read_number_table(file, "numbers");
  if (!table) return table.error();
  std::vector<PoseRow> rows;
  for (const NumberRow& line : *table) {
    const auto fault = [&](const std::string& what) {
      return Error{fmt::format("{}:{}: {}", file.string(), line.line, what)};
    };
    if (line.values.size() != names->size())
      return fault(fmt::format("expected {} numbers, as the first line has names, found {}", names->size(),
                               line.values.size()));
    const Result<PoseRow> row = row_of(line.values, *columns, rows);
    if (!row) return fault(row.error().message);
    rows.push_back(*row);
  }
  return rows;
}

DeviceInput pose_at(const std::vector<PoseRow>& rows, double time) {
  // at rest before the first and after the last row
  TURGOR_ASSERT(!rows.empty(), "a replay has at least one row");
  const auto later = std::upper_bound(rows.begin(), rows.end(), time,
                                      [](double t, const PoseRow& row) { return t < row.time; });
  if (later == rows.begin()) return resting(rows.front());
  const PoseRow& a = *(later - 1);
  if (later == rows.end()) return resting(a);
  // linear interpolation
  const PoseRow& b = *later;
  TURGOR_CHECK(b.time > a.time, "the times of a replay ascend");
  const double duration = b.time - a.time, s = (time - a.time) / duration;
  DeviceInput input = resting(a);
  input.pose = {a.position * (1 - s) + b.position * s, axes_of(between(a.orientation, b.orientation, s))};
  input.velocity = (b.position - a.position) / duration;
  input.angular_velocity =
      rotation_vector(axes_of(b.orientation) * transposed(axes_of(a.orientation))) / duration;
  input.grip = a.grip * (1 - s) + b.grip * s;
  return input;
}

Status Replay::open() {
  close();
  // rows
  if (file_.empty()) return Error{"replay: expected a file of poses (.csv)"};
  Result<std::vector<PoseRow>> rows = read_poses(file_);
  if (!rows) return rows.error();
  rows_ = std::move(*rows);
  // specification: any force, the poses' bounding box
  TURGOR_ASSERT(!rows_.empty(), "a file of poses has at least one row");
  constexpr double kAny = std::numeric_limits<double>::infinity();
  spec_ = {.name = "replay of " + file_.filename().string(),
           .workspace_low = rows_[0].position,
           .workspace_high = rows_[0].position,
           .force = kAny,
           .torque = kAny,
           .grip_force = kAny,
           .stiffness = kAny,
           .damping = kAny,
           .has_orientation = rows_.front().has_orientation,
           .has_grip = true};
  for (const PoseRow& row : rows_) {
    spec_.workspace_low = min(spec_.workspace_low, row.position);
    spec_.workspace_high = max(spec_.workspace_high, row.position);
  }
  start_ = -1;
  return Done{};
}

bool Replay::exchange(const DeviceOutput& /*output*/, DeviceInput& input) noexcept {
  if (rows_.empty()) return false;
  const double now = steady_seconds();
  if (start_ < 0) start_ = now;
  input = pose_at(rows_, rows_.front().time + (now - start_));
  input.time = now;
  return true;
}

void list_replay(const DeviceOptions& options, DeviceListing& listing) {
  listing.note = "ready: name a .csv file of poses";
  if (options.file.empty()) return;
  const Result<std::vector<PoseRow>> rows = read_poses(options.file);
  if (rows) listing.connected.push_back(options.file.string());
  if (!rows) listing.note = rows.error().message;
}

}  // namespace turgor::haptics
