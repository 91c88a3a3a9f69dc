// A folder that lives as long as one test.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

namespace turgor::testing {

class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "turgor-test-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}
inline void spill(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// The result is an error whose message names each of the words.
#define EXPECT_REFUSED(expression, ...)                                                  \
  do {                                                                                   \
    const auto refused_result = (expression);                                            \
    ASSERT_FALSE(refused_result) << "expected an error";                                 \
    for (const std::string refused_word : {__VA_ARGS__})                                 \
      EXPECT_NE(refused_result.error().message.find(refused_word), std::string::npos)    \
          << "\"" << refused_word << "\" is not in: " << refused_result.error().message; \
  } while (false)

}  // namespace turgor::testing
