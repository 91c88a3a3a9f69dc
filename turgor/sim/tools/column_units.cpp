#include "turgor/sim/tools/column_units.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include <fmt/format.h>

namespace turgor {

namespace {

struct Unit {
  const char* name;
  double size;  // in meters, seconds or newtons
};
constexpr double kGramForce = 9.80665e-3;  // [N]
// the unit of the SI first; micro sign and Greek mu
constexpr Unit kLengths[] = {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"µm", 1e-6}, {"μm", 1e-6}};
constexpr Unit kTimes[] = {{"s", 1}, {"sec", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}};
constexpr Unit kForces[] = {{"N", 1},     {"kN", 1e3},       {"cN", 1e-2},       {"mN", 1e-3},
                            {"uN", 1e-6}, {"g", kGramForce}, {"gf", kGramForce}, {"kgf", 1e3 * kGramForce}};

/// Units of a kind of column, and what they measure.
struct Units {
  const char* noun;
  std::span<const Unit> known;
};
Units units_of(ColumnKind kind) {
  if (kind == ColumnKind::kLength) return {"length", kLengths};
  if (kind == ColumnKind::kTime) return {"time", kTimes};
  return {"force", kForces};
}

std::optional<double> size_of(std::string_view unit, std::span<const Unit> units) {
  const auto at = std::find_if(units.begin(), units.end(), [&](const Unit& n) { return unit == n.name; });
  return at == units.end() ? std::nullopt : std::optional(at->size);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// Bytes beyond ASCII count as letters.
bool has_letter(std::string_view word) {
  return std::any_of(word.begin(), word.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalpha(byte) != 0;
  });
}

/// Last word of names such as tool_x and mean_force.
bool names_quantity(std::string_view word) {
  constexpr std::array<std::string_view, 12> kWords{
      "x",        "y",           "z",     "t",    "time", "depth", "distance", "displacement",
      "position", "indentation", "force", "load",
  };
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return char(std::tolower(static_cast<unsigned char>(c))); });
  return std::find(kWords.begin(), kWords.end(), lower) != kWords.end();
}

}  // namespace

std::optional<double> length_unit(std::string_view unit) { return size_of(unit, kLengths); }
std::optional<double> time_unit(std::string_view unit) { return size_of(unit, kTimes); }
std::optional<double> force_unit(std::string_view unit) { return size_of(unit, kForces); }

std::string unit_of(std::string_view column) {
  std::string unquoted(column);
  std::erase(unquoted, '"');
  std::string_view name = trimmed(unquoted);
  // brackets
  if (const std::size_t open = name.find_last_of("[("); open != std::string_view::npos) {
    const std::string_view inside = name.substr(open + 1);
    return std::string(trimmed(inside.substr(0, inside.find_first_of("])"))));
  }
  // the last word with a letter after _ or /
  for (std::string_view rest = name;;) {
    const std::size_t at = rest.find_last_of("_/");
    if (at == std::string_view::npos) break;
    const std::string_view word = trimmed(rest.substr(at + 1));
    if (has_letter(word)) return names_quantity(word) ? "" : std::string(word);
    rest = rest.substr(0, at);
  }
  // a known unit after a blank
  const std::size_t blank = name.find_last_of(' ');
  if (blank == std::string_view::npos) return "";
  const std::string_view last = name.substr(blank + 1);
  return length_unit(last) || time_unit(last) || force_unit(last) ? std::string(last) : "";
}

Result<ColumnUnit> column_unit(const std::filesystem::path& file, const std::string& column,
                               ColumnKind kind) {
  const Units units = units_of(kind);
  const std::string declared = unit_of(column), unit = declared.empty() ? column : declared;
  if (const std::optional<double> size = size_of(unit, units.known)) return ColumnUnit{unit, *size};
  if (declared.empty()) return ColumnUnit{units.known[0].name, 1};
  std::string names;
  for (const Unit& known : units.known) names += fmt::format("{}{}", names.empty() ? "" : ", ", known.name);
  return Error{fmt::format("{}: column \"{:.40}\": expected a unit of {} ({}), found \"{:.40}\"",
                           file.string(), column, units.noun, names, declared)};
}

}  // namespace turgor
