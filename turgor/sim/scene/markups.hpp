// Lines and curves that were drawn in 3D Slicer and saved as Markups (.mrk.json), as paths of cuts.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// A line or curve of one file.
struct Markup {
  std::vector<Vec3d> points;  // at least two, consecutive ones distinct; patient frame LPS [m]
  bool is_line = false;       // two points; otherwise a smooth curve interpolates the points
};

/// True for names that end with .mrk.json.
bool is_markups_file(const std::filesystem::path& file);

/// Reads the only line, curve or closed curve of a file. The first point of a closed curve is also its last.
/// Error: file, location, expected and found value.
Result<Markup> read_markup(const std::filesystem::path& file);
/// The same for text in memory; `file` is used in errors.
Result<Markup> parse_markup(std::string_view text, const std::filesystem::path& file);

}  // namespace turgor
