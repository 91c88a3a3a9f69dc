// Folders and small files for tests. Folders are removed when the test program ends.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <unistd.h>

namespace turgor::test {

/// A new empty folder.
inline std::filesystem::path fresh_folder() {
  static const struct Folders {
    mutable std::vector<std::filesystem::path> all;
    pid_t owner = getpid();
    ~Folders() {
      if (getpid() != owner) return;  // a child ends
      std::error_code ignored;
      for (const auto& folder : all) std::filesystem::remove_all(folder, ignored);
    }
  } folders;
  std::string name = (std::filesystem::temp_directory_path() / "turgor-XXXXXX").string();
  folders.all.push_back(std::filesystem::canonical(mkdtemp(name.data())));
  return folders.all.back();
}

inline void write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}
inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Names in a folder, hidden ones too.
inline std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

}  // namespace turgor::test
