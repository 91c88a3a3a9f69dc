#include "turgor/geometry/hounsfield.hpp"

#include <algorithm>

#include "turgor/core/number_text.hpp"

namespace turgor {

namespace {

/// Fractions of the samples; fat is included in soft.
struct Shares {
  double air = 0, soft = 0, fat = 0, dense = 0;
  int lowest = 0, highest = 0;
};

Shares shares_of(const CtVolume& ct) {
  constexpr std::size_t kEnough = std::size_t{1} << 22;
  const std::size_t step = ct.samples.size() / kEnough + 1;
  std::size_t air = 0, soft = 0, fat = 0, dense = 0, count = 0;
  int lowest = 32767, highest = -32768;
  for (std::size_t i = 0; i < ct.samples.size(); i += step, count++) {
    const int hu = ct.samples[i];
    air += hu >= -1100 && hu <= -900;
    soft += hu >= -200 && hu <= 200;
    fat += hu >= -150 && hu <= -40;
    dense += hu >= 800;
    lowest = std::min(lowest, hu), highest = std::max(highest, hu);
  }
  const double n = double(std::max<std::size_t>(count, 1));
  return {double(air) / n, double(soft) / n, double(fat) / n, double(dense) / n, lowest, highest};
}

/// True if there is air around soft tissue, or fat between muscles with little bone, as in a crop from inside
/// a body.
bool looks_like_ct(const Shares& s) {
  const bool has_air = s.air >= 0.002 && s.soft >= 0.01;
  const bool is_piece = s.soft >= 0.3 && s.fat >= 0.005 && s.dense < 0.1;
  return has_air || is_piece;
}

}  // namespace

std::string doubt_of_hounsfield_units(const CtVolume& ct) {
  const Shares s = shares_of(ct);
  if (looks_like_ct(s)) return {};
  return "these numbers do not look like Hounsfield units of a CT: " + number_text(100 * s.air) +
         " % are near air (-1100 to -900), " + number_text(100 * s.soft) +
         " % near soft tissue (-200 to 200), from " + std::to_string(s.lowest) + " to " +
         std::to_string(s.highest) + "; the classification into air, fat, muscle and bone would be wrong";
}

}  // namespace turgor
