#include "turgor/sim/tools/force_curve.hpp"

#include <array>
#include <string>

#include <fmt/format.h>

#include "turgor/io/files/number_table.hpp"
#include "turgor/sim/tools/column_units.hpp"

namespace turgor {

namespace {

/// Scale factors of the two columns to meters and newtons, from the first line.
Result<std::array<double, 2>> scales_of(const std::filesystem::path& file) {
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  if (names->size() != 2) return std::array<double, 2>{1, 1};
  const std::string first = unit_of((*names)[0]), second = unit_of((*names)[1]);
  if (force_unit(first) && length_unit(second))
    return Error{
        fmt::format("{}: expected a depth before its force, found the columns \"{:.40}\" and \"{:.40}\"",
                    file.string(), (*names)[0], (*names)[1])};
  return std::array<double, 2>{length_unit(first).value_or(1), force_unit(second).value_or(1)};
}

}  // namespace

Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file) {
  // read rows and unit scales
  const std::string expected = "two numbers, a depth [m] and a force [N]";
  const Result<std::vector<NumberRow>> rows = read_number_table(file, expected);
  if (!rows) return rows.error();
  const Result<std::array<double, 2>> scales = scales_of(file);
  if (!scales) return scales.error();
  // convert each row to meters and newtons
  std::vector<rhombus::CurvePoint> curve;
  for (const NumberRow& row : *rows) {
    if (row.values.size() != 2)
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), row.line, expected, row.text)};
    curve.push_back({row.values[0] * (*scales)[0], row.values[1] * (*scales)[1]});
  }
  return curve;
}

}  // namespace turgor
