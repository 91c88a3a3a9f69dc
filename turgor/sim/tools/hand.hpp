// Recorded hand motion: one row per tick with the whole command of the tool. forces.csv of a run is such a
// file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/contact/tool_io.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

constexpr std::size_t kMostHandRows = std::size_t(1) << 22;  // as many as a log holds

struct HandRow {
  double time = 0;  // [s]
  contact::ToolCommand command;
};

/// Reads a comma-separated table whose first line names its columns. time_s, x_m, y_m and z_m are required.
/// The tool's axes (axis_x_x … axis_z_z, in the patient frame), grip and hold are optional; other columns are
/// ignored. A column `tool` selects the rows of that name. Times ascend. Error: file, line, what was expected
/// and found.
Result<std::vector<HandRow>> read_hand(const std::filesystem::path& file, const std::string& tool);

/// Column names that read_hand accepts, in order, without `tool`.
std::vector<std::string> hand_columns();

/// Command at a time: the latest row up to then.
const HandRow& hand_at(const std::vector<HandRow>& hand, double time);

/// The same as a path, for pictures and for times between two ticks.
ToolPath path_of(const std::vector<HandRow>& hand);

}  // namespace turgor
