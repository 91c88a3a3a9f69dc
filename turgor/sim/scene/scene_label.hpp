// Labels of a segmentation by number or by name, for scenes and commands.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/io/volume/organ_names.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Names of the labels of a table's `labels`: those of the file, else those of TotalSegmentator and of the
/// phantoms.
struct SceneLabels {
  LabelNames names;
  std::string file;       // empty: a phantom
  bool is_usual = false;  // true if the file has no names
  std::string note;       // set once a TotalSegmentator name was used for a file without names
};
SceneLabels scene_labels(SceneTable& table);
/// Label names of a file.
SceneLabels labels_of(const std::filesystem::path& file);

/// Label with that name or number. The error states what was expected and found, without a source location.
Result<int> find_label(const std::string& name, SceneLabels& labels);
/// Label with that name or number; 0, and a problem of the table, if there is none.
int find_label(SceneTable& table, const std::string& key, const std::string& name, SceneLabels& labels);
/// Label from a number or a name.
void read_label(SceneTable& table, const std::string& key, SceneLabels& labels, int& label, Meaning meaning);

}  // namespace turgor
