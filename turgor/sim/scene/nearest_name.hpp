// "Did you mean" suggestions by the Damerau-Levenshtein distance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Insertions, deletions, replacements and swaps of neighbors that turn `a` into `b`.
int edit_distance(std::string_view a, std::string_view b);
/// Nearest of `names`, or empty if more than a third of the letters would have to change.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);
/// "; did you mean NAME?" or, if no name is near, "; known are A, B and C".
std::string suggestion(std::string_view name, const std::vector<std::string>& names);

}  // namespace turgor
