// What label numbers mean in segmentations: what their file says, else what they mean to TotalSegmentator
// (version 2, task "total"), the usual tool, and in our phantoms.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace turgor {

using LabelNames = std::map<int, std::string>;  // by label

/// "liver" for 5; empty for numbers without a name.
std::string organ_name(int label);
/// All that organ_name knows.
LabelNames usual_names();
/// The label of that name, or the number that the text is, 1 to 65535; -1 when it is neither.
int label_number(const LabelNames& names, std::string_view name);

}  // namespace turgor
