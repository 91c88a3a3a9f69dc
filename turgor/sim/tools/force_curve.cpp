#include "turgor/sim/tools/force_curve.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include <fmt/format.h>

#include "turgor/io/files/number_table.hpp"

namespace turgor {

namespace {

struct Named {
  const char* unit;
  double size;  // in meters or newtons
};
constexpr std::array<Named, 6> kLengths{{{"m", 1},
                                         {"cm", 1e-2},
                                         {"mm", 1e-3},
                                         {"um", 1e-6},
                                         {"µm", 1e-6},
                                         {"μm", 1e-6}}};  // micro sign, Greek mu
constexpr std::array<Named, 3> kForces{{{"N", 1}, {"mN", 1e-3}, {"gf", 9.80665e-3}}};

/// Letters at the end of a column name: "mm" of depth_mm and of depth[mm].
std::string unit_of(std::string_view name) {
  const auto is_letter = [](char c) {  // bytes beyond ASCII count as letters
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalpha(byte) != 0;
  };
  while (!name.empty() && !is_letter(name.back())) name.remove_suffix(1);
  std::size_t begin = name.size();
  while (begin > 0 && is_letter(name[begin - 1])) begin--;
  return std::string(name.substr(begin));
}

template <std::size_t kCount>
std::optional<double> size_of(const std::string& unit, const std::array<Named, kCount>& units) {
  const auto at = std::find_if(units.begin(), units.end(), [&](const Named& n) { return unit == n.unit; });
  return at == units.end() ? std::nullopt : std::optional(at->size);
}

/// Scale factors of the two columns to meters and newtons, from the first line.
Result<std::array<double, 2>> scales_of(const std::filesystem::path& file) {
  const Result<std::vector<std::string>> names = read_column_names(file);
  if (!names) return names.error();
  if (names->size() != 2) return std::array<double, 2>{1, 1};
  const std::string first = unit_of((*names)[0]), second = unit_of((*names)[1]);
  if (size_of(first, kForces) && size_of(second, kLengths))
    return Error{
        fmt::format("{}: expected a depth before its force, found the columns \"{:.40}\" and \"{:.40}\"",
                    file.string(), (*names)[0], (*names)[1])};
  return std::array<double, 2>{size_of(first, kLengths).value_or(1), size_of(second, kForces).value_or(1)};
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
