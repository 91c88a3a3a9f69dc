// Needle: a straight rigid shaft with a cone as its tip. In the tool's frame the tip is at the origin and the
// shaft along positive z, so that it is pushed along negative z. It cuts a crack into the tissue, the track.
// needle_touch.hpp has its state, its equations and its tick.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

/// Shape of a needle and resistance of the tissue to it.
struct Needle {
  double length = 0.08;          // of the shaft [m]
  double diameter = 0.001;       // of the shaft, and width of the crack [m]
  double tip_angle = 20;         // full angle of the cone [degrees]
  double toughness = 164;        // J: work to tear a unit area inside of the tissue [J/m²]
  double entry_toughness = 328;  // the same of the surface or capsule that is punctured first [J/m²]
  double exit_toughness = 328;   // the same of the surface through which it leaves the body [J/m²]
  double friction = 1.4;         // along the shaft, per length [N/m]
  double spreading = 6e4;        // pressure of the tissue on the tip, which spreads the crack [Pa]
  double spacing = 0.001;        // of the points that couple shaft and tissue [m]
  double bending = 0;            // EI: bending stiffness of the shaft; 0 = rigid (needle_beam.hpp) [N·m²]
  double bevel = 90;             // angle between the tip's face and the shaft; 90 = no bevel [degrees]
  double bevel_toward = 0;  // side of its edge about the shaft, from the tool's x to its y axis [degrees]
};

constexpr double kSteel = 2e11;  // Young's modulus [Pa]

constexpr int kMostNeedlePoints = 240;    // of one track
constexpr double kLeastToughness = 1e-3;  // less counts as this: a micronewton at 1 mm [J/m²]

/// Length of the cone [m].
inline double cone_length(const Needle& needle) {
  TURGOR_CHECK(needle.tip_angle > 0 && needle.tip_angle < 180, "a tip is a cone");
  return needle.diameter / 2 / std::tan(needle.tip_angle / 2 * std::numbers::pi / 180);
}
/// Cross section of the needle at this distance behind its tip [m²].
inline double cross_section(const Needle& needle, double behind) {
  const double share = std::clamp(behind / cone_length(needle), 0.0, 1.0);
  return std::numbers::pi / 4 * needle.diameter * needle.diameter * share * share;
}
/// Volume of the needle's first `behind` meters [m³].
inline double volume_behind_tip(const Needle& needle, double behind) {
  const double cone = cone_length(needle), whole = std::numbers::pi / 4 * needle.diameter * needle.diameter;
  const double in_cone = std::clamp(behind, 0.0, cone), after = std::max(0.0, behind - cone);
  return whole * (in_cone * in_cone * in_cone / (3 * cone * cone) + after);
}
/// Bending stiffness of a solid shaft [N·m²].
inline double bending_stiffness(double diameter, double young) {
  return young * std::numbers::pi / 64 * diameter * diameter * diameter * diameter;
}
/// Length of a bevel's face along the shaft [m].
inline double bevel_length(const Needle& needle) {
  return needle.diameter / std::tan(needle.bevel * std::numbers::pi / 180);
}
/// Distance of the crack from the shaft's axis: a sharp bevel cuts at its edge, a blunt tip in its middle
/// [m].
inline double bevel_offset(const Needle& needle) {
  return needle.bevel < 90 ? needle.diameter / 2 * std::cos(needle.bevel * std::numbers::pi / 180) : 0;
}
/// Force on the tip that tears tissue of this toughness [N]. It is positive, because a tip without force
/// has left the tissue.
inline double tearing_force(const Needle& needle, double toughness) {
  return std::max(toughness, kLeastToughness) * needle.diameter;
}

}  // namespace turgor::contact
