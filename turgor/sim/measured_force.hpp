// Measured force of a tool over depth or time, read from a table of two columns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Measured force of a tool.
struct MeasuredForce {
  bool by_time = false;       // abscissa: time [s]; else depth below the surface at rest [m]
  std::vector<double> at;     // ascending
  std::vector<double> force;  // [N]
  std::string tool;           // its name in the scene; empty: the first
  std::string units;          // by which its file was read, "mm, N"; empty: no file
};
/// Reads two columns with a header such as depth_mm,force_N or time [s],force [mN]; without a header, depth
/// [m] and force [N]. Error: file, line or column, expected and found.
Result<MeasuredForce> read_measured_force(const std::filesystem::path& file);

/// Error: a number that is not finite, a row below the previous one or below 0, or no force.
Status check_measured(const MeasuredForce& measured);

}  // namespace turgor
