#include "turgor/sim/tools/force_curve.hpp"

#include <array>
#include <string>

#include <fmt/format.h>

#include "turgor/io/files/number_table.hpp"
#include "turgor/sim/tools/column_units.hpp"

namespace turgor {

namespace {

/// Units of the two columns, from the first line.
Result<std::array<ColumnUnit, 2>> units_of_curve(const std::filesystem::path& file) {
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  if (names->size() != 2) {
    // a line of another number of words is a title, unless it declares units
    for (const std::string& name : *names)
      if (!unit_of(name).empty())
        return Error{fmt::format("{}: expected the names of two columns, a depth and a force, found {}",
                                 file.string(), names->size())};
    return std::array<ColumnUnit, 2>{ColumnUnit{"m", 1}, ColumnUnit{"N", 1}};
  }
  const std::string &first = (*names)[0], &second = (*names)[1];
  if (force_unit(unit_of(first)) && length_unit(unit_of(second)))
    return Error{
        fmt::format("{}: expected a depth before its force, found the columns \"{:.40}\" and \"{:.40}\"",
                    file.string(), first, second)};
  const Result<ColumnUnit> depth = column_unit(file, first, ColumnKind::kLength);
  if (!depth) return depth.error();
  const Result<ColumnUnit> force = column_unit(file, second, ColumnKind::kForce);
  if (!force) return force.error();
  return std::array<ColumnUnit, 2>{*depth, *force};
}

}  // namespace

Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file) {
  // read rows and units
  const std::string expected = "two numbers, a depth [m] and a force [N]";
  const Result<std::vector<NumberRow>> rows = read_number_table(file, expected);
  if (!rows) return rows.error();
  const Result<std::array<ColumnUnit, 2>> units = units_of_curve(file);
  if (!units) return units.error();
  // convert each row to meters and newtons
  std::vector<rhombus::CurvePoint> curve;
  for (const NumberRow& row : *rows) {
    if (row.values.size() != 2)
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), row.line, expected, row.text)};
    curve.push_back({row.values[0] * (*units)[0].size, row.values[1] * (*units)[1].size});
  }
  return curve;
}

Result<std::string> force_curve_units(const std::filesystem::path& file) {
  const Result<std::array<ColumnUnit, 2>> units = units_of_curve(file);
  if (!units) return units.error();
  return (*units)[0].name + ", " + (*units)[1].name;
}

}  // namespace turgor
