#include "turgor/io/files/number_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

bool is_blank(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string::npos || line[first] == '#';
}

std::vector<std::string> words_of(std::string line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';' || c == '\t' || c == '\r'; }, ' ');
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// Column names of a line. If it has commas, semicolons or tabs, blanks are part of a name.
std::vector<std::string> names_of(const std::string& line) {
  constexpr const char* kBetween = ",;\t\r";
  if (line.find_first_of(",;\t") == std::string::npos) return words_of(line);
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < line.size();) {
    const std::size_t end = std::min(line.find_first_of(kBetween, begin), line.size());
    const std::size_t first = line.find_first_not_of(' ', begin), last = line.find_last_not_of(' ', end - 1);
    if (first < end) names.push_back(line.substr(first, last + 1 - first));
    begin = end + 1;
  }
  return names;
}

/// Whole word as a number, possibly not a finite one.
std::optional<double> number_of(const std::string& word) {
  char* end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  return end != word.c_str() && *end == '\0' ? std::optional(number) : std::nullopt;
}

/// Numbers of a line; empty if it holds anything else.
std::vector<double> numbers_of(const std::string& line) {
  std::vector<double> numbers;
  for (const std::string& word : words_of(line)) {
    const std::optional<double> number = number_of(word);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// True for a line of column names. A row with a typing error or NaN has other numbers.
bool is_header(const std::string& line) {
  const std::vector<std::string> names = names_of(line);
  return std::none_of(names.begin(), names.end(),
                      [](const std::string& name) { return number_of(name).has_value(); });
}

/// Text of a file without the byte-order mark of spreadsheets.
Result<std::string> read_table_text(const std::filesystem::path& file) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  Result<std::string> text = read_file(file);
  if (text && text->starts_with(kMark)) text->erase(0, kMark.size());
  return text;
}

}  // namespace

Result<std::vector<NumberRow>> read_number_table(const std::filesystem::path& file,
                                                 const std::string& expected) {
  const Result<std::string> text = read_table_text(file);
  if (!text) return text.error();
  std::vector<NumberRow> rows;
  std::istringstream lines(*text);
  int number = 0;
  bool begun = false;
  for (std::string line; std::getline(lines, line);) {
    number++;
    if (is_blank(line)) continue;
    const bool is_first = !std::exchange(begun, true);
    if (is_first && is_header(line)) continue;
    std::vector<double> values = numbers_of(line);
    if (values.empty())
      return Error{
          fmt::format("{}:{}: expected {}, found \"{:.60}\"", file.string(), number, expected, line)};
    rows.push_back({number, std::move(values), line});
  }
  if (rows.empty())
    return Error{fmt::format("{}: expected lines of {}, found none", file.string(), expected)};
  return rows;
}

Result<std::vector<std::string>> read_column_names(const std::filesystem::path& file) {
  const Result<std::string> text = read_table_text(file);
  if (!text) return text.error();
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);)
    if (!is_blank(line)) return is_header(line) ? names_of(line) : std::vector<std::string>();
  return std::vector<std::string>();
}

}  // namespace turgor
