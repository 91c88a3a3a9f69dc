// Names of label numbers in segmentations: from the file, else those of TotalSegmentator (version 2, task
// "total"), and those of the built-in phantoms.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace turgor {

using LabelNames = std::map<int, std::string>;  // by label

/// "liver" for 5; empty for numbers without a name.
std::string organ_name(int label);
/// All names that organ_name knows.
LabelNames usual_names();
/// Label of a name, or the number in the text, 1 to 65535; -1 if it is neither.
int label_number(const LabelNames& names, std::string_view name);

}  // namespace turgor
