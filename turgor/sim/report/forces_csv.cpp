#include "turgor/sim/report/forces_csv.hpp"

#include <iterator>

#include <fmt/format.h>

#include "turgor/io/file.hpp"

namespace turgor {

namespace {

/// The columns of a hand, to the last bit: read back, they move the tool in just the same way.
void append_command(const ForceSample& s, std::string& text) {
  const auto append = [&text](double value) { fmt::format_to(std::back_inserter(text), ",{}", value); };
  append(s.time);
  for (int i = 0; i < 3; i++) append(s.position[i]);
  for (const Vec3d axis : s.axes.column)
    for (int i = 0; i < 3; i++) append(axis[i]);
  append(s.grip);
  append(s.hold ? 1 : 0);
}

void append_row(const std::string& tool, const ForceSample& s, std::string& text) {
  text += tool;
  append_command(s, text);
  fmt::format_to(std::back_inserter(text), ",{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{},{:.9g},{:.9g}\n",
                 s.force.x, s.force.y, s.force.z, s.torque.x, s.torque.y, s.torque.z, s.contacts, s.depth,
                 s.path);
}

}  // namespace

Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools) {
  std::string text = fmt::format(
      "tool,{},force_x_N,force_y_N,force_z_N,torque_x_Nm,torque_y_Nm,torque_z_Nm,"
      "contacts,depth_m,path_m\n",
      fmt::join(hand_columns(), ","));
  for (const TouchingTool& tool : tools) {
    append_row(tool.name, tool.samples.start(), text);
    for (const ForceSample& s : tool.samples) append_row(tool.name, s, text);
  }
  return write_file(path, text);
}

}  // namespace turgor
