// What label numbers mean in segmentations by TotalSegmentator (version 2, task "total"), the usual tool.
#pragma once

#include <string>

namespace turgor {

/// "liver" for 5; empty for numbers without a name.
std::string organ_name(int label);

}  // namespace turgor
