// What fuzz targets that read files share: a folder as long as the program runs, and a check that ends it.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

struct FuzzFolder {
  std::filesystem::path path;
  FuzzFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "turgor-fuzz-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

inline void require(bool condition) {
  if (!condition) std::abort();
}
