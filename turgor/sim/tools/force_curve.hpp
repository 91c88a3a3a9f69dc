// Measured force–depth curves: text with two numbers a line, depth [m] and force [N].
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor {

/// Commas, semicolons, tabs or blanks between the numbers; lines that start with # are skipped. A first line
/// of two names may end them with units, as depth_mm and force_mN; else metres and newtons are meant. Error:
/// the file, the line, what was expected and what was found.
Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file);

}  // namespace turgor
