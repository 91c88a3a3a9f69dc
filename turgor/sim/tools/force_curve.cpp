#include "turgor/sim/tools/force_curve.hpp"

#include <fmt/format.h>

#include "turgor/io/number_table.hpp"

namespace turgor {

Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file) {
  const std::string expected = "two numbers, a depth [m] and a force [N]";
  const Result<std::vector<NumberRow>> rows = read_number_table(file, expected);
  if (!rows) return rows.error();
  std::vector<rhombus::CurvePoint> curve;
  for (const NumberRow& row : *rows) {
    if (row.values.size() != 2)
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), row.line, expected, row.text)};
    curve.push_back({row.values[0], row.values[1]});
  }
  return curve;
}

}  // namespace turgor
