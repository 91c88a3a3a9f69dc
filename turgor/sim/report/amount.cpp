#include "turgor/sim/report/amount.hpp"

#include <array>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

using Ladder = std::array<std::string_view, 4>;
constexpr Ladder kTimes{"ns", "µs", "ms", "s"}, kSizes{"bytes", "kB", "MB", "GB"};

/// Selects the unit in steps of a thousand.
std::string climbed(double number, std::string_view unit, const Ladder& ladder) {
  auto rung = std::find(ladder.begin(), ladder.end(), unit);
  TURGOR_CHECK(rung != ladder.end(), "the unit belongs to the ladder");
  for (; std::next(rung) != ladder.end() && std::abs(number) >= 1000; ++rung) number *= 1e-3;
  return fmt::format("{} {}", number_of(number), *rung);
}

}  // namespace

std::string number_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
  if (!value.is_number()) return "";
  const double number = value.get<double>(), size = std::abs(number);
  if (number == 0) return "0";
  if (size >= 100 && size < 1e6) return fmt::format("{:.0f}", number);
  if (size >= 10 && size < 1e6) return fmt::format("{:.1f}", number);
  return size >= 0.01 && size < 1e6 ? fmt::format("{:.2f}", number) : fmt::format("{:.2g}", number);
}

std::string amount(const Json& value, const Unit& unit) {
  const std::string_view text = unit.text;
  if (!value.is_number() || text.empty()) return number_of(value);
  for (const Ladder& ladder : {kTimes, kSizes})
    if (std::find(ladder.begin(), ladder.end(), text) != ladder.end())
      return climbed(value.get<double>(), text, ladder);
  return number_of(value) + (text == "°" ? "°" : fmt::format(" {}", text));
}

}  // namespace turgor
