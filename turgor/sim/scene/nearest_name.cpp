#include "turgor/sim/scene/nearest_name.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace turgor {

int edit_distance(std::string_view a, std::string_view b) {
  // Rows of the Damerau-Levenshtein table: distances from prefixes of a to all prefixes of b.
  std::vector<int> before(b.size() + 1), previous(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); j++) row[j] = int(j);
  for (std::size_t i = 1; i <= a.size(); i++) {
    before = std::exchange(previous, row);
    row[0] = int(i);
    for (std::size_t j = 1; j <= b.size(); j++) {
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (a[i - 1] != b[j - 1])});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  constexpr std::size_t kLongestName = 200;  // longer names are ignored; the table is quadratic
  if (names.empty() || name.size() > kLongestName) return "";
  const auto nearest = std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  const int letters = int(std::max(name.size(), nearest->size()));
  return edit_distance(name, *nearest) <= std::max(1, (letters + 1) / 3) ? *nearest : "";
}

std::string suggestion(std::string_view name, const std::vector<std::string>& names) {
  if (const std::string nearest = nearest_name(name, names); !nearest.empty())
    return fmt::format("; did you mean {}?", nearest);
  if (names.empty()) return "";
  if (names.size() == 1) return fmt::format("; known is {}", names[0]);
  const std::vector<std::string> all_but_last(names.begin(), names.end() - 1);
  return fmt::format("; known are {} and {}", fmt::join(all_but_last, ", "), names.back());
}

}  // namespace turgor
