#include "turgor/sim/measured_force.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/number_table.hpp"
#include "turgor/sim/tools/column_units.hpp"

namespace turgor {

namespace {

/// Units of the two columns.
struct TableUnits {
  bool by_time = false;
  ColumnUnit at{"m", 1}, force{"N", 1};
};
bool names_time(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return char(std::tolower(static_cast<unsigned char>(c))); });
  return name.find("time") != std::string::npos;
}
Result<TableUnits> table_units(const std::filesystem::path& file) {
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  TableUnits units;
  const bool has_meaning = std::any_of(names->begin(), names->end(), [](const std::string& name) {
    return !unit_of(name).empty() || names_time(name);
  });
  if (names->size() != 2 && !has_meaning) return units;  // none, or a title
  const std::string &first = names->front(), &second = names->back();
  if (names->size() != 2 || (force_unit(unit_of(first)) && !force_unit(unit_of(second))))
    return Error{
        fmt::format("{}: expected columns such as depth_mm,force_N or time_s,force_N, found {} names, from "
                    "\"{:.40}\" to \"{:.40}\"",
                    file.string(), names->size(), first, second)};
  units.by_time = names_time(first) || time_unit(unit_of(first));
  const Result<ColumnUnit> at =
      column_unit(file, first, units.by_time ? ColumnKind::kTime : ColumnKind::kLength);
  if (!at) return at.error();
  const Result<ColumnUnit> force = column_unit(file, second, ColumnKind::kForce);
  if (!force) return force.error();
  units.at = *at, units.force = *force;
  return units;
}

}  // namespace

Status check_measured(const MeasuredForce& measured) {
  TURGOR_ASSERT(measured.at.size() == measured.force.size(), "a force a row");
  std::size_t most = 0;  // row of the largest force
  for (std::size_t i = 0; i < measured.at.size(); i++) {
    if (!std::isfinite(measured.at[i]) || !std::isfinite(measured.force[i]))
      return Error{fmt::format("row {}: expected finite numbers", i + 1)};
    if (i > 0 && !(measured.at[i] > measured.at[i - 1]))
      return Error{fmt::format("row {}: expected a {} above {:.6g}, found {:.6g}", i + 1,
                               measured.by_time ? "time" : "depth", measured.at[i - 1], measured.at[i])};
    if (measured.at[i] < 0)
      return Error{fmt::format("row {}: expected a {} from 0, found {:.6g}", i + 1,
                               measured.by_time ? "time" : "depth", measured.at[i])};
    if (std::abs(measured.force[i]) > std::abs(measured.force[most])) most = i;
  }
  if (measured.at.empty() || measured.force[most] == 0)
    return Error{"expected a force that is not zero in every row"};
  // some cells count a press as negative; noise around zero may have either sign
  if (measured.force[most] < 0)
    return Error{
        fmt::format("row {}: expected the size of the tool's force, found {:.6g} N as the largest: "
                    "change the sign of the column",
                    most + 1, measured.force[most])};
  return Done{};
}

Result<MeasuredForce> read_measured_force(const std::filesystem::path& file) {
  const Result<TableUnits> units = table_units(file);
  if (!units) return units.error();
  const std::string expected =
      units->by_time ? "two numbers, a time and a force" : "two numbers, a depth and a force";
  const Result<std::vector<NumberRow>> rows = read_number_table(file, expected);
  if (!rows) return rows.error();
  MeasuredForce measured{.by_time = units->by_time, .units = units->at.name + ", " + units->force.name};
  for (const NumberRow& row : *rows) {
    if (row.values.size() != 2)
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), row.line, expected, row.text)};
    measured.at.push_back(row.values[0] * units->at.size);
    measured.force.push_back(row.values[1] * units->force.size);
  }
  if (const Status status = check_measured(measured); !status)
    return Error{fmt::format("{}: {}", file.string(), status.error().message)};
  return measured;
}

}  // namespace turgor
