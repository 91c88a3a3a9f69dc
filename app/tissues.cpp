// `turgor tissues`: lists the presets of tissues, skin and fabrics with values, test, species and source.
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

struct TissueOptions {
  std::string name, json;
};

Json describe(const TissuePreset& preset) {
  Json values = Json::array();
  for (const PresetValue& value : preset.values) {
    Json row{{"key", value.key}, {"value", value.value}, {"unit", value.unit}};
    if (value.low < value.high) row["low"] = value.low, row["high"] = value.high;
    values.push_back(row);
  }
  return {
      {"name", preset.name}, {"kind", kind_name(preset.kind)}, {"law", preset.law},      {"values", values},
      {"test", preset.test}, {"species", preset.species},      {"source", preset.source}};
}

void print_preset(const TissuePreset& preset) {
  std::string values;
  for (const PresetValue& value : preset.values)
    values += fmt::format("{}{} {}", values.empty() ? "" : "; ", value.key, value_text(value));
  print_plain("  {:<22} {:<7} {}: {}\n", preset.name, kind_name(preset.kind), preset.law, values);
  print_plain("  {:<22} {:<7} {}; {}; {}\n", "", "", preset.species, preset.test, preset.source);
}

/// All presets, or those of a name.
std::vector<TissuePreset> chosen_presets(const std::string& name) {
  std::vector<TissuePreset> chosen;
  std::vector<std::string> names;
  for (const TissuePreset& preset : tissue_presets()) {
    names.push_back(preset.name);
    if (name.empty() || preset.name == name) chosen.push_back(preset);
  }
  if (!chosen.empty()) return chosen;
  const std::string nearest = nearest_name(name, names);
  throw Failure{2, fmt::format("{}: no preset has this name{}", name,
                               nearest.empty() ? "; turgor tissues lists all"
                                               : fmt::format("; did you mean {}?", nearest))};
}

void run_tissues(const TissueOptions& options) {
  if (!options.json.empty()) required(check_file_goal(options.json));
  Json list = Json::array();
  for (const TissuePreset& preset : chosen_presets(options.name))
    print_preset(preset), list.push_back(describe(preset));
  if (options.name.empty())
    print_plain("Values that neither a scene nor a preset sets are {}.\nSkin: {}.\n", kPlainDefaults,
                kSkinDefaults);
  if (options.json.empty()) return;
  const Json json{{"presets", list}, {"defaults", kPlainDefaults}, {"skin_defaults", kSkinDefaults}};
  required(write_file(options.json, json_text(json, 2) + "\n"));
}

}  // namespace

void add_tissues_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "tissues", "List presets of tissues, skin and fabrics: measured values with test, species and source");
  auto options = std::make_shared<TissueOptions>();
  command->add_option("name", options->name, "Only this preset");
  command->add_option("--json", options->json, "Also write the output to this file");
  command->footer(
      "In a scene: tissue = \"liver\". Which preset fits which body: docs/choosing-a-tissue.md\n"
      "Example:\n  turgor tissues\n  turgor tissues liver --json liver.json");
  command->callback([options] { run_tissues(*options); });
}

}  // namespace turgor
