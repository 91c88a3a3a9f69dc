// The text in front of NRRD and MetaImage samples: fields of name and value, and the numbers in them.
// Internal to io/.
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
  std::map<std::string, std::string, std::less<>> free;  // NRRD: "key:=value", of whoever wrote the file

  bool has(std::string_view key) const { return values.find(key) != values.end(); }
  std::string get(std::string_view key) const {
    const auto found = values.find(key);
    return found == values.end() ? std::string{} : found->second;
  }
};

/// "key: value" lines up to an empty line; `end` is the first byte after it. A key that comes twice is an
/// error.
Result<TextFields> read_nrrd_fields(const std::filesystem::path& path, std::string_view head,
                                    std::size_t& end);
/// "Key = Value" lines up to and with ElementDataFile.
Result<TextFields> read_meta_fields(const std::filesystem::path& path, std::string_view head,
                                    std::size_t& end);

std::string trimmed(std::string_view text);
std::vector<std::string_view> words(std::string_view text);
/// The whole numbers in a text of words; empty when a word is none.
std::vector<std::int64_t> whole_numbers(std::string_view text);
/// The real numbers in a text of words; empty when a word is none, or is not finite.
std::vector<double> real_numbers(std::string_view text);
/// Whether a unit of length is the millimetre, or says nothing.
bool is_millimeter(std::string_view unit);

}  // namespace turgor::io
