#include "turgor/io/files/number_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

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

/// Numbers of a line; empty if it holds anything else.
std::vector<double> numbers_of(const std::string& line) {
  std::vector<double> numbers;
  for (const std::string& word : words_of(line)) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0' || !std::isfinite(numbers.back())) return {};
  }
  return numbers;
}

}  // namespace

Result<std::vector<NumberRow>> read_number_table(const std::filesystem::path& file,
                                                 const std::string& expected) {
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  std::vector<NumberRow> rows;
  std::istringstream lines(*text);
  int number = 0;
  bool begun = false;
  for (std::string line; std::getline(lines, line);) {
    number++;
    if (is_blank(line)) continue;
    std::vector<double> values = numbers_of(line);
    const bool names = values.empty() && !begun;
    begun = true;
    if (names) continue;
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
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);)
    if (!is_blank(line)) return numbers_of(line).empty() ? names_of(line) : std::vector<std::string>();
  return std::vector<std::string>();
}

}  // namespace turgor
