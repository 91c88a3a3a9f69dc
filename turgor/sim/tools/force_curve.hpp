// Measured force–depth curves: text with two numbers a line, depth [m] and force [N].
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor {

/// Commas, semicolons, tabs or blanks between the numbers; a first line of names and lines that start with #
/// are skipped. Error: the file, the line, what was expected and what was found.
Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file);

}  // namespace turgor
