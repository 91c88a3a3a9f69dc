#include "turgor/sim/report/forces_csv.hpp"

#include <iterator>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/quantity.hpp"

namespace turgor {

namespace {

using namespace units;
using F = ForceSample;

/// Forces, which follow the columns of the hand motion.
const Quantity<F> kFelt[] = {
    {"force_x", kNewtons, "", [](const F& s) -> Json { return s.force.x; }},
    {"force_y", kNewtons, "", [](const F& s) -> Json { return s.force.y; }},
    {"force_z", kNewtons, "", [](const F& s) -> Json { return s.force.z; }},
    {"torque_x", kTorque, "", [](const F& s) -> Json { return s.torque.x; }},
    {"torque_y", kTorque, "", [](const F& s) -> Json { return s.torque.y; }},
    {"torque_z", kTorque, "", [](const F& s) -> Json { return s.torque.z; }},
    {"contacts", kCount, "", [](const F& s) -> Json { return s.contacts; }},
    {"depth", kMeters, "", [](const F& s) -> Json { return s.depth; }},
    {"path", kMeters, "", [](const F& s) -> Json { return s.path; }},
};

std::string cell(const Json& value) {
  return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.dump();
}

/// Columns of the hand motion with full precision, so that a replay is exact.
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
  for (const Quantity<F>& column : kFelt) text += "," + cell(column.of(s));
  text += "\n";
}

}  // namespace

Status write_forces(const std::filesystem::path& path, const std::vector<TouchingTool>& tools) {
  // header
  Result<FileWriter> file = FileWriter::create(path);
  if (!file) return file.error();
  std::string text = fmt::format("tool,{}", fmt::join(hand_columns(), ","));
  for (const Quantity<F>& column : kFelt) text += "," + full_key(column.key, column.unit);
  text += "\n";
  // rows, in blocks: the ticks of a long session do not fit in memory
  constexpr std::size_t kBytesAtOnce = 1 << 20;
  for (const TouchingTool& tool : tools) {
    append_row(tool.name, tool.samples.start(), text);
    for (const ForceSample& s : tool.samples) {
      append_row(tool.name, s, text);
      if (text.size() < kBytesAtOnce) continue;
      file->write(text);
      text.clear();
    }
  }
  file->write(text);
  return file->commit();
}

}  // namespace turgor
