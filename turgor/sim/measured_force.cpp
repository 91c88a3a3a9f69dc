#include "turgor/sim/measured_force.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/number_table.hpp"

namespace turgor {

namespace {

/// Unit in brackets or after the last underscore of a column name.
std::string column_unit(std::string name) {
  std::erase_if(name, [](char c) { return c == '[' || c == ']' || c == ' ' || c == '"'; });
  const std::size_t at = name.find_last_of('_');
  return at == std::string::npos ? "" : name.substr(at + 1);
}

struct ColumnUnits {
  bool by_time = false;
  double at = 1, force = 1;  // to SI
};
Result<ColumnUnits> column_units(const std::filesystem::path& file) {
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  ColumnUnits units;
  if (names->size() != 2) return units;
  static const std::map<std::string, double> kAt{
      {"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"s", 1}, {"ms", 1e-3}};
  static const std::map<std::string, double> kForce{{"N", 1}, {"mN", 1e-3}, {"gf", 9.80665e-3}};
  const std::string first = column_unit((*names)[0]), second = column_unit((*names)[1]);
  units.by_time = (*names)[0].find("time") != std::string::npos || first == "s" || first == "ms";
  const auto at = kAt.find(first.empty() ? (units.by_time ? "s" : "m") : first);
  const auto force = kForce.find(second.empty() ? "N" : second);
  if (at == kAt.end() || force == kForce.end() || units.by_time != (at->first == "s" || at->first == "ms"))
    return Error{
        fmt::format("{}: expected columns such as depth_mm,force_N or time_s,force_N, found \"{:.40}\" "
                    "and \"{:.40}\"",
                    file.string(), (*names)[0], (*names)[1])};
  units.at = at->second, units.force = force->second;
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
  const Result<ColumnUnits> units = column_units(file);
  if (!units) return units.error();
  const std::string expected =
      units->by_time ? "two numbers, a time and a force" : "two numbers, a depth and a force";
  const Result<std::vector<NumberRow>> rows = read_number_table(file, expected);
  if (!rows) return rows.error();
  MeasuredForce measured{.by_time = units->by_time};
  for (const NumberRow& row : *rows) {
    if (row.values.size() != 2)
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), row.line, expected, row.text)};
    measured.at.push_back(row.values[0] * units->at), measured.force.push_back(row.values[1] * units->force);
  }
  if (const Status status = check_measured(measured); !status)
    return Error{fmt::format("{}: {}", file.string(), status.error().message)};
  return measured;
}

}  // namespace turgor
