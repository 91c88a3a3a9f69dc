#include "turgor/io/mesh/unit_question.hpp"

#include <fmt/format.h>

namespace turgor {

namespace {

struct LengthUnit {
  const char* name;
  double meters;
};
constexpr LengthUnit kUnits[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"km", 1e3}};
constexpr double kUsual = 0.2;  // size of an organ, a garment or a tool [m]

/// Distance from the usual size, as a factor of at least 1.
double oddness(double size) { return size > kUsual ? size / kUsual : kUsual / size; }

std::string length_text(double size) {
  return size >= 1 ? fmt::format("{:.3g} m", size) : fmt::format("{:.3g} mm", 1e3 * size);
}

}  // namespace

std::string unit_question(double size) {
  if (!(size > 0) || (size <= kLargestMesh && size >= kSmallestMesh)) return "";
  // the unit that makes the size most usual
  const LengthUnit* best = &kUnits[0];
  for (const LengthUnit& unit : kUnits)
    if (oddness(size * unit.meters) < oddness(size * best->meters)) best = &unit;
  return fmt::format("{} wide: is it in {}? scale = {:g}", length_text(size), best->name, best->meters);
}

}  // namespace turgor
