#include "turgor/sim/force_curve.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "turgor/io/file.hpp"

namespace turgor {

namespace {

/// The numbers of a line; empty when there is something else in it.
std::vector<double> numbers_of(std::string line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';' || c == '\t' || c == '\r'; }, ' ');
  std::istringstream stream(line);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0' || !std::isfinite(numbers.back())) return {};
  }
  return numbers;
}

bool is_blank(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos || line[line.find_first_not_of(" \t")] == '#';
}

}  // namespace

Result<std::vector<rhombus::CurvePoint>> read_force_curve(const std::filesystem::path& file) {
  Result<std::string> text = read_file(file);
  if (!text) return text.error();
  std::vector<rhombus::CurvePoint> curve;
  std::istringstream lines(*text);
  int number = 0, filled = 0;
  for (std::string line; std::getline(lines, line);) {
    number++;
    if (is_blank(line)) continue;
    const std::vector<double> values = numbers_of(line);
    if (values.empty() && filled++ == 0) continue;  // names
    filled++;
    if (values.size() != 2)
      return Error{fmt::format("{}:{}: expected two numbers, a depth [m] and a force [N], found \"{:.60}\"",
                               file.string(), number, line)};
    curve.push_back({values[0], values[1]});
  }
  if (curve.empty())
    return Error{
        fmt::format("{}: expected lines with a depth [m] and a force [N], found none", file.string())};
  return curve;
}

}  // namespace turgor
