// Units in the column names of tables, as in depth_mm, time [ms] and Force (g).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor {

/// Size of a unit in meters, seconds or newtons; none if it is no such unit. A gram of force is "g" or "gf".
std::optional<double> length_unit(std::string_view unit);
std::optional<double> time_unit(std::string_view unit);
std::optional<double> force_unit(std::string_view unit);

/// Unit that a column name declares, known or not: the text of its last brackets, "mm" of depth [mm] and of
/// depth (mm); else the word after its last `_` or `/`, "mm" of depth_mm; else a known unit after a blank.
/// Empty: none. A word such as depth or x after `_` names the column and is no unit.
std::string unit_of(std::string_view name);

/// Physical quantity of a column.
enum class ColumnKind : std::uint8_t { kLength, kTime, kForce };

struct ColumnUnit {
  std::string name;  // "mm"
  double size = 1;   // in meters, seconds or newtons
};
/// Unit by which a column is read. Without a declared unit it is that of the SI, or the whole name where the
/// name is a unit of this kind. Error: file, column, the known units and the unknown one.
Result<ColumnUnit> column_unit(const std::filesystem::path& file, const std::string& column, ColumnKind kind);

}  // namespace turgor
