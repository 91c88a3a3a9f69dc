// The curve that a blade is drawn along, before it is laid on the skin, and where it meets blades that were
// there before: what they cut has moved since, while their wounds opened.
#pragma once

#include <algorithm>

#include "turgor/models/lattice/cutting/blade_sheet.hpp"

namespace turgor::lattice {

inline double smallest_step(const Lattice& l) { return std::min({l.step.x, l.step.y, l.step.z}); }

/// What an incision goes through, lattice frame [m]; two make a straight line.
std::vector<Vec3d> drawn_points(const Model& model, const Incision& incision);
/// The smooth curve through them, as points about half a step apart [m]. The same first and last point close
/// it.
std::vector<Vec3d> drawn_curve(const Model& model, const Incision& incision);

/// The line from the skin downwards that an earlier blade cut, where the tissue is now; empty: none is met.
struct MetLine {
  static constexpr int kAbove = 4;  // places above the skin
  double step = 0;                  // between depths [m]
  Vec3d end;                        // on the skin, where it was met [m]
  std::vector<Vec3d> places;        // at an end of the cut a little back, within it [m]
};
/// Ends of a curve that were drawn on the curve of a laid blade go where the tissue is that this one cut, or
/// will cut, there; the curve beside them bends to them. `others` as of Inputs.
std::array<MetLine, 2> meet_laid_blades(const Model& model, const State& state,
                                        std::span<const LaidBlade> laid, const HaloExchange* halo,
                                        std::vector<Vec3d>& curve);
/// Adds what lies between the ends of a path and the lines that they meet, at every depth. `tilt` [radians].
void join_sheet(const BladePath& path, const std::array<MetLine, 2>& met, double tilt, BladeSheet& sheet);

}  // namespace turgor::lattice
