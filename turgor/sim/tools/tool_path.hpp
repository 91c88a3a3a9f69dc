// Pose of a tool over time: rows of a scene or a .csv file, with interpolation.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/quaternion.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Rows in ascending time; the tool rests before the first and after the last.
struct ToolPath {
  std::vector<PathRow> rows;  // at least one
  bool smooth = false;        // monotone cubic interpolation without overshoot
};

/// Rows of [t, x, y, z], optionally with hold (0 or 1) and a quaternion w, x, y, z. Error: the first row with
/// a wrong length, a value that is not finite, or a time not after the previous one.
Result<std::vector<PathRow>> path_rows(const std::vector<std::vector<double>>& rows);
/// The same from a file. Names in the first line may declare units, as in t_ms and x_mm. Errors name file,
/// and line or column.
Result<std::vector<PathRow>> read_path_rows(const std::filesystem::path& file);

/// Interpolated pose at a time.
PathRow path_at(const ToolPath& path, double time);

/// Shortest rotation from the z axis to `z` (unit), as a quaternion.
Quaternion turned_to(Vec3d z);

}  // namespace turgor
