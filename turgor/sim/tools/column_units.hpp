// Units at the end of column names of tables, as in depth_mm and time[ms].
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace turgor {

/// Letters at the end of a column name: "mm" of depth_mm and of depth[mm].
std::string unit_of(std::string_view name);
/// Size of a unit in meters, seconds or newtons; none if it is no such unit.
std::optional<double> length_unit(std::string_view unit);
std::optional<double> time_unit(std::string_view unit);
std::optional<double> force_unit(std::string_view unit);

}  // namespace turgor
