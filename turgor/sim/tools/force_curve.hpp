// Measured force–depth curves: text with two numbers per line, depth [m] and force [N].
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor {

/// Reads a curve. Separators are commas, semicolons, tabs or blanks; lines that start with # are skipped. A
/// first line with two names may declare units, as in depth_mm and force_mN; the default is meters and
/// newtons. Error: file, line or column, what was expected and found.
Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file);
/// Units by which the columns are read, "mm, N".
Result<std::string> force_curve_units(const std::filesystem::path& file);

}  // namespace turgor
