#include "turgor/sim/tools/column_units.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace turgor {

namespace {

struct Unit {
  const char* name;
  double size;  // in meters, seconds or newtons
};

template <std::size_t kCount>
std::optional<double> size_of(std::string_view unit, const std::array<Unit, kCount>& units) {
  const auto at = std::find_if(units.begin(), units.end(), [&](const Unit& n) { return unit == n.name; });
  return at == units.end() ? std::nullopt : std::optional(at->size);
}

}  // namespace

std::string unit_of(std::string_view name) {
  const auto is_letter = [](char c) {  // bytes beyond ASCII count as letters
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalpha(byte) != 0;
  };
  while (!name.empty() && !is_letter(name.back())) name.remove_suffix(1);
  std::size_t begin = name.size();
  while (begin > 0 && is_letter(name[begin - 1])) begin--;
  return std::string(name.substr(begin));
}

std::optional<double> length_unit(std::string_view unit) {
  return size_of(unit, std::array<Unit, 6>{{{"m", 1},
                                            {"cm", 1e-2},
                                            {"mm", 1e-3},
                                            {"um", 1e-6},
                                            {"µm", 1e-6},
                                            {"μm", 1e-6}}});  // micro sign, Greek mu
}
std::optional<double> time_unit(std::string_view unit) {
  return size_of(unit, std::array<Unit, 4>{{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}}});
}
std::optional<double> force_unit(std::string_view unit) {
  return size_of(unit, std::array<Unit, 3>{{{"N", 1}, {"mN", 1e-3}, {"gf", 9.80665e-3}}});
}

}  // namespace turgor
