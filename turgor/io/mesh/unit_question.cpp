#include "turgor/io/mesh/unit_question.hpp"

#include <fmt/format.h>

namespace turgor {

namespace {

struct LengthUnit {
  const char* name;
  double meters;
};
constexpr LengthUnit kUnits[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"km", 1e3}};
// Usual sizes [m].
constexpr double kUsualOrgan = 0.2;  // or tool
constexpr double kUsualGarment = 0.8, kSmallestGarment = 0.2;

/// Distance from the usual size, as a factor of at least 1.
double oddness(double size, double usual) { return size > usual ? size / usual : usual / size; }

std::string length_text(double size) {
  return size >= 1 ? fmt::format("{:.3g} m", size) : fmt::format("{:.3g} mm", 1e3 * size);
}

}  // namespace

std::string unit_question(double size, Meshed meshed) {
  if (!(size > 0) || (size <= kLargestMesh && size >= kSmallestMesh)) return "";
  // the unit that makes the size most usual
  const double usual = meshed == Meshed::kGarment ? kUsualGarment : kUsualOrgan;
  const LengthUnit* best = &kUnits[0];
  for (const LengthUnit& unit : kUnits)
    if (oddness(size * unit.meters, usual) < oddness(size * best->meters, usual)) best = &unit;
  const double meters = size * best->meters;
  if (meshed == Meshed::kGarment && (meters < kSmallestGarment || meters > kLargestMesh))
    return fmt::format("{} wide, as no garment: scale = {:.2g} makes it {:g} m wide", length_text(size),
                       usual / size, usual);
  return fmt::format("{} wide: is it in {}? scale = {:g}", length_text(size), best->name, best->meters);
}

}  // namespace turgor
