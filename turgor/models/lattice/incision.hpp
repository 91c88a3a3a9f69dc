// Cutting: a blade is drawn along a line on the skin, and every lattice edge that crosses the surface it
// sweeps is cut. Measures of the wound that opens.
#pragma once

#include <string>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct Incision {
  std::string name;
  Vec3d from, to;       // on or near the skin, patient frame [m]
  double depth = 0.01;  // below the skin [m]
  double start = 0;     // when the blade starts [s]
  double duration = 0;  // how long it takes from `from` to `to`; 0 = at once [s]
  double width = 0;  // 0 = cut edges; else the paper's static region of this width, which leaves the body [m]
};

/// The blade's path laid on the skin as it is now. Made when the blade starts, followed while it moves.
struct BladePath {
  std::vector<Vec3d> skin;  // points on it from `from` to `to`, half a step apart, lattice frame [m]
  Vec3d into;               // unit, into the body
  Vec3d across;             // unit, across the cut
  double depth = 0;         // [m]
  VecField u;               // where the tissue was then, by slot; the cut is one clean surface in it [m]
};

/// Lays the path on the skin. Error: no skin there, or an incision without length.
Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision);
/// Cuts what lies between two fractions of the path's length, and returns how many edges it cut.
int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end,
              int incision);
/// The paper's static incision: nodes within `width`/2 of the blade leave the body. Returns how many.
int cut_region(const Model& model, State& state, const BladePath& path, double width, int incision);

struct GapePoint {
  double along = 0;  // distance along the cut [m]
  double gape = 0;   // [m]
};
struct Wound {
  double length = 0;                   // of the cut skin [m]
  double gape_max = 0, gape_mean = 0;  // opening across the cut [m]
  double opening_area = 0;             // [m²]
  double edge_displacement = 0;        // largest movement of a lip since the CT [m]
  std::vector<GapePoint> profile;
};
Wound measure_wound(const Model& model, const State& state, const BladePath& path, int incision);

}  // namespace turgor::lattice
