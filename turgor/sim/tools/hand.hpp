// A hand as it was recorded: one row a tick, each the whole of what the tool was told. forces.csv of a run is
// such a file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/contact/tool_io.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

constexpr std::size_t kMostHandRows = std::size_t(1) << 22;  // as many as a log keeps

struct HandRow {
  double time = 0;  // [s]
  contact::ToolCommand command;
};

/// Rows of a table with commas whose first line names its columns: time_s, x_m, y_m, z_m are needed; the
/// tool's axes (axis_x_x … axis_z_z, each axis as it lies in the world), grip and hold if they are there;
/// others are not read. With a column `tool`, the rows of that name. Times ascend. Error: file, line, what
/// was expected and found.
Result<std::vector<HandRow>> read_hand(const std::filesystem::path& file, const std::string& tool);

/// The names of the columns that read_hand understands, in order, without `tool`.
std::vector<std::string> hand_columns();

/// What the hand does at a time: the row that is the newest then.
const HandRow& hand_at(const std::vector<HandRow>& hand, double time);

/// As a path, for pictures and for whoever asks between two ticks.
ToolPath path_of(const std::vector<HandRow>& hand);

}  // namespace turgor
