#include "turgor/sim/report/require.hpp"

#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

namespace turgor {

namespace {

/// Entry of a list by name or by index.
const Json* entry_of(const Json& list, const std::string& word) {
  for (const Json& entry : list)
    if (entry.is_object() && entry.value("name", Json()) == word) return &entry;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool is_number = error == std::errc() && end == word.data() + word.size();
  return is_number && number < list.size() ? &list[number] : nullptr;
}

const Json* find(const Json& report, const std::string& key) {
  const Json* at = &report;
  std::istringstream words(key);
  for (std::string word; at && std::getline(words, word, '.');) {
    if (at->is_array())
      at = entry_of(*at, word);
    else
      at = at->is_object() && at->contains(word) ? &at->at(word) : nullptr;
  }
  return at;
}

bool holds(double value, const Requirement& requirement) {
  if (requirement.comparison == "<") return value < requirement.bound;
  if (requirement.comparison == "<=") return value <= requirement.bound;
  if (requirement.comparison == ">") return value > requirement.bound;
  return value >= requirement.bound;
}

}  // namespace

Result<Requirement> read_requirement(const std::string& text) {
  const std::size_t sign = text.find_first_of("<>");
  const Error wrong{fmt::format(
      "--require: expected a number of report.json and its bound, as haptics.missed<0.001, found \"{}\"",
      text)};
  if (sign == std::string::npos || sign == 0) return wrong;
  const bool with_equal = sign + 1 < text.size() && text[sign + 1] == '=';
  Requirement out{text.substr(0, sign), text.substr(sign, with_equal ? 2 : 1), 0};
  const std::string bound = text.substr(sign + out.comparison.size());
  const auto [end, error] = std::from_chars(bound.data(), bound.data() + bound.size(), out.bound);
  if (error != std::errc() || end != bound.data() + bound.size() || !std::isfinite(out.bound)) return wrong;
  return out;
}

Result<std::string> missed_by(const Json& report, const Requirement& requirement) {
  const Json* value = find(report, requirement.key);
  if (!value || !value->is_number())
    return Error{fmt::format("--require: expected a number of report.json, found no {}", requirement.key)};
  const double found = value->get<double>();
  if (holds(found, requirement)) return std::string();
  return fmt::format("required {}{}{}, found {}", requirement.key, requirement.comparison, requirement.bound,
                     found);
}

}  // namespace turgor
