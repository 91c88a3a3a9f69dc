#include "turgor/sim/report/forces_csv.hpp"

#include <fmt/format.h>

#include "turgor/io/file.hpp"
#include "turgor/sim/report/quantity.hpp"

namespace turgor {

namespace {

using namespace units;
using F = ForceSample;

const Quantity<F> kColumns[] = {
    {"time", kSeconds, "", [](const F& s) -> Json { return s.time; }},
    {"x", kMetres, "", [](const F& s) -> Json { return s.position.x; }},
    {"y", kMetres, "", [](const F& s) -> Json { return s.position.y; }},
    {"z", kMetres, "", [](const F& s) -> Json { return s.position.z; }},
    {"force_x", kNewtons, "", [](const F& s) -> Json { return s.force.x; }},
    {"force_y", kNewtons, "", [](const F& s) -> Json { return s.force.y; }},
    {"force_z", kNewtons, "", [](const F& s) -> Json { return s.force.z; }},
    {"torque_x", kTorque, "", [](const F& s) -> Json { return s.torque.x; }},
    {"torque_y", kTorque, "", [](const F& s) -> Json { return s.torque.y; }},
    {"torque_z", kTorque, "", [](const F& s) -> Json { return s.torque.z; }},
    {"contacts", kCount, "", [](const F& s) -> Json { return s.contacts; }},
    {"depth", kMetres, "", [](const F& s) -> Json { return s.depth; }},
    {"path", kMetres, "", [](const F& s) -> Json { return s.path; }},
};

std::string cell(const Json& value) {
  return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.dump();
}

}  // namespace

Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools) {
  std::string text = "tool";
  for (const Quantity<F>& column : kColumns) text += "," + full_key(column.key, column.unit);
  text += "\n";
  for (const TouchingTool& tool : tools)
    for (const ForceSample& sample : tool.samples) {
      text += tool.name;
      for (const Quantity<F>& column : kColumns) text += "," + cell(column.of(sample));
      text += "\n";
    }
  return write_file(path, text);
}

}  // namespace turgor
