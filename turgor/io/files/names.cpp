#include "turgor/io/files/names.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

/// Levenshtein distance: letters to add, remove or replace to turn a into b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); i++) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); j++) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::vector<std::string> nearest_names(const fs::path& folder, const std::string& name) {
  std::vector<std::pair<std::size_t, std::string>> found;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string other = entry.path().filename().string();
    const bool continues = !name.empty() && other.starts_with(name);
    found.emplace_back(continues ? 1 : edit_distance(name, other), other);
    if (found.size() == 10000) break;
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> nearest;
  for (const auto& [distance, other] : found)
    if (nearest.size() < 3 && distance <= std::max<std::size_t>(2, name.size() / 3)) nearest.push_back(other);
  return nearest;
}

}  // namespace

std::string not_found(const fs::path& path) {
  if (!path.has_filename() && path.has_relative_path()) return not_found(path.parent_path());  // FOLDER/
  const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
  std::error_code failed;
  if (!fs::is_directory(folder, failed))
    return fmt::format("{}: does not exist; neither does the folder {}", path.string(), folder.string());
  const auto nearest = nearest_names(folder, path.filename().string());
  if (nearest.empty()) return fmt::format("{}: does not exist", path.string());
  return fmt::format("{}: does not exist; did you mean {}?", path.string(), fmt::join(nearest, " or "));
}

}  // namespace turgor::io
