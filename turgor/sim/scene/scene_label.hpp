// Labels of a segmentation as a scene, or a command, names them: by number, or by name.
#pragma once

#include <filesystem>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/io/volume/organ_names.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// What the labels of a table's `labels` are called: as their file says, else as the usual segmentation tool
/// calls them, and our phantoms.
struct SceneLabels {
  LabelNames names;
  std::string file;       // empty: a phantom's
  bool is_usual = false;  // the file names none
  std::string note;       // once a usual name was taken for a label of a file that names none
};
SceneLabels scene_labels(SceneTable& table);
/// Of a file.
SceneLabels labels_of(const std::filesystem::path& file);

/// The label of that name or number; the error says what was expected and found, and no place.
Result<int> find_label(const std::string& name, SceneLabels& labels);
/// The label of that name or number; 0, and a problem of the table, when it is neither.
int find_label(SceneTable& table, const std::string& key, const std::string& name, SceneLabels& labels);
/// A label by number or by name, from a number or a text.
void read_label(SceneTable& table, const std::string& key, SceneLabels& labels, int& label, Meaning meaning);

}  // namespace turgor
