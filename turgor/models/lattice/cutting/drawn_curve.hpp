// Curve of an incision as drawn, before it is laid on the skin, and its junctions with earlier incisions. An
// earlier wound has opened, so the tissue at its cut has moved.
#pragma once

#include <algorithm>

#include "turgor/models/lattice/cutting/blade_sheet.hpp"

namespace turgor::lattice {

inline double smallest_spacing(const Lattice& l) { return std::min({l.spacing.x, l.spacing.y, l.spacing.z}); }

/// Control points of an incision, lattice frame [m]. Two points make a straight line.
std::vector<Vec3d> drawn_points(const Model& model, const Incision& incision);
/// Smooth curve through the control points, sampled about every half cell [m]. Equal first and last points
/// close it.
std::vector<Vec3d> drawn_curve(const Model& model, const Incision& incision);

/// Line along an earlier cut, from above the skin downwards, at current positions of the tissue. Empty if the
/// curve meets no earlier cut.
struct JunctionLine {
  static constexpr int kAbove = 4;  // number of points above the skin
  double step = 0;                  // distance in depth between points [m]
  Vec3d end;                        // end point of the new curve, on the skin [m]
  std::vector<Vec3d> points;        // points on the earlier cut [m]
};
/// Joins the ends of a curve to earlier incisions. An end that was drawn on a laid blade's curve moves to the
/// tissue which that blade cut. The curve bends near this end. `halo` as in Inputs.
std::array<JunctionLine, 2> join_laid_blades(const Model& model, const State& state,
                                             std::span<const LaidBlade> laid, const HaloExchange* halo,
                                             std::vector<Vec3d>& curve);
/// Adds strips of the sheet between each end of a path and its junction line, at every depth. `tilt` is in
/// radians.
void join_sheet(const BladePath& path, const std::array<JunctionLine, 2>& met, double tilt,
                BladeSheet& sheet);

}  // namespace turgor::lattice
