#include "turgor/io/files/header_text.hpp"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "turgor/io/files/file_cursor.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kSpace = " \t\r\n\v\f";

/// Reads the line at `at` and advances `at` past it; false if the text ends before the line does.
bool next_line(std::string_view text, std::size_t& at, std::string_view& line) {
  const std::size_t end = text.find('\n', at);
  if (end == text.npos) return false;
  line = text.substr(at, end - at);
  if (line.ends_with('\r')) line.remove_suffix(1);
  at = end + 1;
  return true;
}

Error endless(const fs::path& path) {
  return {fmt::format("{}: truncated or corrupt: the header does not end", path.string())};
}

/// Field names are case-insensitive, and some have a second name.
std::string nrrd_key(std::string_view written) {
  static const std::map<std::string, std::string> kSecond = {
      {"datafile", "data file"}, {"lineskip", "line skip"}, {"byteskip", "byte skip"},
      {"axismins", "axis mins"}, {"axismaxs", "axis maxs"}, {"centers", "centerings"}};
  std::string key = lower_case(written);
  const auto found = kSecond.find(key);
  return found == kSecond.end() ? key : found->second;
}

Status insert(const fs::path& path, TextFields& fields, std::string key, std::string value) {
  if (!fields.values.emplace(key, std::move(value)).second)
    return Error{fmt::format("{}: corrupt: the header says \"{}\" twice", path.string(), key)};
  return Done{};
}

}  // namespace

std::string trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == text.npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kSpace) - begin + 1));
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  for (std::size_t at = text.find_first_not_of(kSpace); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    found.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return found;
}

std::vector<std::int64_t> whole_numbers(std::string_view text) {
  std::vector<std::int64_t> numbers;
  for (const std::string_view word : words(text)) {
    std::int64_t number = 0;
    const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (failed != std::errc{} || end != word.data() + word.size()) return {};
    numbers.push_back(number);
  }
  return numbers;
}

std::vector<double> real_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (std::string_view word : words(text)) {
    if (word.starts_with('+')) word.remove_prefix(1);
    double number = 0;
    const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (failed != std::errc{} || end != word.data() + word.size() || !std::isfinite(number)) return {};
    numbers.push_back(number);
  }
  return numbers;
}

bool is_millimeter(std::string_view unit) {
  for (const char* known : {"mm", "millimeter", "millimeters", "millimetre", "millimetres", "", "?", "???"})
    if (unit == known) return true;
  return false;
}

Result<TextFields> read_nrrd_fields(const fs::path& path, std::string_view head, std::size_t& end) {
  TextFields fields;
  std::string_view line;
  end = 0;
  if (!next_line(head, end, line)) return endless(path);
  if (line < "NRRD0001" || line > "NRRD0005")
    return Error{fmt::format("{}: \"{}\"; expected NRRD0001 to NRRD0005", path.string(), line.substr(0, 60))};
  for (;;) {
    if (!next_line(head, end, line)) {
      if (fields.has("data file")) return fields;  // a detached header needs no empty line
      return endless(path);
    }
    if (line.empty()) return fields;
    if (line.starts_with('#')) continue;
    const std::size_t colon = line.find(": "), free_text = line.find(":=");
    if (free_text < colon) {  // "key:=value" is free text; the first one counts
      fields.free.emplace(line.substr(0, free_text), trimmed(line.substr(free_text + 2)));
      continue;
    }
    if (colon == line.npos)
      return Error{fmt::format("{}: corrupt: header line \"{}\"", path.string(), line.substr(0, 60))};
    const std::string key = nrrd_key(line.substr(0, colon));
    if (Status done = insert(path, fields, key, trimmed(line.substr(colon + 2))); !done) return done.error();
  }
}

Result<TextFields> read_meta_fields(const fs::path& path, std::string_view head, std::size_t& end) {
  TextFields fields;
  std::string_view line;
  end = 0;
  while (next_line(head, end, line)) {
    const std::size_t equal = line.find('=');
    if (trimmed(line).empty()) continue;
    if (equal == line.npos || line.find('\0') != line.npos)
      return Error{fmt::format("{}: corrupt: header line \"{}\"", path.string(), line.substr(0, 60))};
    const std::string key = trimmed(line.substr(0, equal));
    if (Status done = insert(path, fields, key, trimmed(line.substr(equal + 1))); !done) return done.error();
    if (key == "ElementDataFile") return fields;
  }
  return endless(path);
}

}  // namespace turgor::io
