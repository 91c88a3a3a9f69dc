// Text headers of NRRD and MetaImage files: fields of name and value, and the numbers in them. Internal to
// io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::io {

struct TextFields {
  std::map<std::string, std::string, std::less<>> values;
  std::map<std::string, std::string, std::less<>> free;  // NRRD: "key:=value" pairs of the writing program

  bool has(std::string_view key) const { return values.find(key) != values.end(); }
  std::string get(std::string_view key) const {
    const auto found = values.find(key);
    return found == values.end() ? std::string{} : found->second;
  }
};

/// Reads "key: value" lines up to an empty line; `end` is the first byte after it. A duplicate key is an
/// error.
Result<TextFields> read_nrrd_fields(const std::filesystem::path& path, std::string_view head,
                                    std::size_t& end);
/// Reads "Key = Value" lines up to and including ElementDataFile.
Result<TextFields> read_meta_fields(const std::filesystem::path& path, std::string_view head,
                                    std::size_t& end);

std::string trimmed(std::string_view text);
std::vector<std::string_view> words(std::string_view text);
/// Integers of a text; empty if a word is not an integer.
std::vector<std::int64_t> whole_numbers(std::string_view text);
/// Real numbers of a text; empty if a word is not a finite number.
std::vector<double> real_numbers(std::string_view text);
/// True if a unit of length is the millimeter or unspecified.
bool is_millimeter(std::string_view unit);

}  // namespace turgor::io
