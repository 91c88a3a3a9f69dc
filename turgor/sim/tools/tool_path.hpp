// Where a tool is over time: rows of a scene or of a .csv file, and what lies between them.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/quaternion.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Rows by ascending time; before the first and after the last the tool rests there.
struct ToolPath {
  std::vector<PathRow> rows;  // at least one
  bool smooth = false;        // monotone cubics: they pass every row and never swing beyond two neighbours
};

/// Rows of [t, x, y, z], with hold (0 or 1) fifth and a quaternion w, x, y, z after it if wanted. Error:
/// which row is no such row, holds a number that is none, or comes before the one above it.
Result<std::vector<PathRow>> path_rows(const std::vector<std::vector<double>>& rows);
/// The same from a file; a first line of names is skipped. Errors name file and line.
Result<std::vector<PathRow>> read_path_rows(const std::filesystem::path& file);

/// The tool at a time; `time` of the answer is that time.
PathRow path_at(const ToolPath& path, double time);

/// The quaternion that turns the z axis into `z` (unit) by the shortest way.
Quaternion turned_to(Vec3d z);

}  // namespace turgor
