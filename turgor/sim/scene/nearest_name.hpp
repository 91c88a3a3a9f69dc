// "Did you mean": the known name that is nearest to a misspelt one, by the number of typing slips between
// them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Insertions, removals, replacements and swaps of neighbours that turn `a` into `b`.
int edit_distance(std::string_view a, std::string_view b);
/// The nearest of `names`, or nothing when none is near (more than a third of the letters would have to
/// change).
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);
/// "; did you mean NAME?" or, when none is near, "; known are A, B and C".
std::string suggestion(std::string_view name, const std::vector<std::string>& names);

}  // namespace turgor
