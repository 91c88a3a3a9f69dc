#include "turgor/sim/report/forces_csv.hpp"

#include <iterator>

#include <fmt/format.h>

#include "turgor/io/file.hpp"

namespace turgor {

Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools) {
  std::string text =
      "tool,time_s,x_m,y_m,z_m,force_x_N,force_y_N,force_z_N,torque_x_Nm,torque_y_Nm,torque_z_Nm,contacts,"
      "depth_m,path_m\n";
  for (const TouchingTool& tool : tools)
    for (const ForceSample& s : tool.samples)
      fmt::format_to(
          std::back_inserter(text),
          "{},{:.6g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{},{:.9g},{:.9g}\n",
          tool.name, s.time, s.position.x, s.position.y, s.position.z, s.force.x, s.force.y, s.force.z,
          s.torque.x, s.torque.y, s.torque.z, s.contacts, s.depth, s.path);
  return write_file(path, text);
}

}  // namespace turgor
