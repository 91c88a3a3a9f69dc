// Folders and small files for tests.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace turgor::test {

/// A new empty folder.
inline std::filesystem::path fresh_folder() {
  std::string path = testing::TempDir() + "/turgor-XXXXXX";
  return std::filesystem::canonical(mkdtemp(path.data()));
}

inline void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// Names in a folder, hidden ones too.
inline std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

}  // namespace turgor::test
