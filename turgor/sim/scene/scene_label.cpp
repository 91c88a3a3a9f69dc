#include "turgor/sim/scene/scene_label.hpp"

#include "turgor/io/ct.hpp"
#include "turgor/sim/scene/nearest_name.hpp"

namespace turgor {

namespace {

constexpr const char* kExpected = "a label's number (1 to 65535) or an organ's name";

/// "; did you mean liver?" for a misspelt name.
std::string label_suggestion(const std::string& name, const SceneLabels& labels) {
  std::vector<std::string> names;
  for (const auto& [label, own] : labels.names) names.push_back(own);
  const std::string nearest = nearest_name(name, names);
  if (!nearest.empty()) return "; did you mean " + nearest + "?";
  return labels.is_usual || labels.file.empty() ? "" : fmt::format("; {} has no such label", labels.file);
}

}  // namespace

SceneLabels labels_of(const std::filesystem::path& file) {
  SceneLabels labels{.names = read_label_names(file), .file = file.string()};
  labels.is_usual = labels.names.empty();
  if (labels.is_usual) labels.names = usual_names();
  return labels;
}

SceneLabels scene_labels(SceneTable& table) {
  const toml::node* node = table.find("labels");
  if (!node || node->is_table()) return {.names = usual_names()};
  std::filesystem::path file;
  table.read_path("labels", file, "a segmentation");
  return labels_of(file);
}

Result<int> find_label(const std::string& name, SceneLabels& labels) {
  const int label = label_number(labels.names, name);
  if (label < 0)
    return Error{fmt::format("expected {}, found \"{}\"{}", kExpected, name, label_suggestion(name, labels))};
  const bool is_name = name.find_first_not_of("0123456789") != name.npos;
  if (labels.is_usual && is_name)
    labels.note = fmt::format(
        "{}: the file names none of its labels: \"{}\" is taken to be label {}, as TotalSegmentator numbers "
        "them",
        labels.file, name, label);
  return label;
}

int find_label(SceneTable& table, const std::string& key, const std::string& name, SceneLabels& labels) {
  const Result<int> label = find_label(name, labels);
  if (!label) table.fail(key, label.error().message);
  return label ? *label : 0;
}

void read_label(SceneTable& table, const std::string& key, SceneLabels& labels, int& label, Meaning meaning) {
  table.describe(key, "", meaning.fallback ? meaning.fallback : "required", meaning.text);
  const toml::node* node = table.find(key);
  if (!node) return;
  if (node->is_integer()) return table.read(key, label, within(1, 65535), meaning);
  if (!node->is_string()) return table.fail_value(key, *node, kExpected);
  label = find_label(table, key, node->as_string()->get(), labels);
}

}  // namespace turgor
