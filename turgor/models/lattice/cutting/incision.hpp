// Cutting: a blade is drawn along a curve on the skin, and every edge of the lattice, and of the fine
// lattice, that crosses the surface it sweeps is cut. Measures of the wound that opens.
#pragma once

#include <span>
#include <string>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct Incision {
  std::string name;
  Vec3d from, to;  // on or near the skin, patient frame [m]
  std::vector<Vec3d>
      path;             // instead: what a smooth curve goes through; the same first and last point close it
  double depth = 0.01;  // below the skin [m]
  double tilt = 0;  // of the blade from upright, its edge to the right of its way seen from outside [degrees]
  double start = 0;     // when the blade starts [s]
  double duration = 0;  // how long it takes from one end to the other; 0 = at once [s]
  double width = 0;  // 0 = cut edges; else the paper's static region of this width, which leaves the body [m]
};

/// An edge of the lattice that a blade will cut when it comes by.
struct PendingEdgeCut {
  int slot = 0;
  std::uint8_t family = 0;
  Real along = 0;  // [m]
};

/// A line through a cell that a blade will cross when it comes by (cut_fraction.hpp).
struct PendingSampleCut {
  int slot = 0;  // of the cell's lowest node
  std::uint8_t axis = 0, line = 0;
  Real along = 0;  // [m]
};

/// The blade's path laid on the skin as it is when the blade starts, followed while it moves.
struct BladePath {
  std::vector<Vec3d>
      skin;  // points on it from one end to the other, about half a step apart, lattice frame [m]
  std::vector<Vec3d> into;      // at each: unit, into the body, at right angles to the path
  double depth = 0, width = 0;  // [m]

  // All that the blade will cut: the tissue as it lies when it is set on the skin. What the wound does to the
  // tissue ahead of the blade does not bend the cut: else it would leave bridges and islands.
  std::vector<PendingEdgeCut> edges;
  std::vector<CutEdge> fine_edges;
  std::vector<PendingSampleCut> lines;
};

/// A blade that was laid before in the same body. One whose end is drawn on its curve meets it in the tissue.
struct LaidBlade {
  const Incision& drawn;
  const BladePath& path;
};

/// Lays the path on the skin. Error: no skin there, or an incision without length. `others` as of Inputs.
Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision,
                            const HaloExchange* halo = nullptr, std::span<const LaidBlade> laid = {});
/// Cuts what lies between two fractions of the path's length, and returns how many edges of the lattice it
/// cut. Of where nodes are it asks beside the blade alone.
int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end, int incision,
              const DownloadNodes& bring = {});
/// The paper's static incision: nodes within `width`/2 of the blade leave the body. Returns how many.
int cut_region(const Model& model, State& state, const BladePath& path);

double path_length(const BladePath& path);
/// Which point of the path is this far along it: index and rest, 0 to 1.
struct PathPlace {
  std::size_t n = 0;
  double rest = 0;
};
PathPlace place_along(const BladePath& path, double along);
/// Unit vectors at a point of the path: along it, and across it, to its right seen from outside.
Vec3d line_at(const BladePath& path, std::size_t n);
Vec3d across_at(const BladePath& path, std::size_t n);
/// Into the body, the mean along the path.
Vec3d mean_into(const BladePath& path);

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

struct BodySurface;
/// Between the lips of the cut as they are drawn; a removed region between the nodes of skin beside it.
Wound measure_wound(const Model& model, const State& state, const BodySurface& surface, const BladePath& path,
                    int incision);
/// The same for a surface of its own.
Wound measure_wound(const Model& model, const State& state, const BladePath& path, int incision);
/// The nodes whose displacements it looks at, ascending: they follow from the cuts.
std::vector<int> nodes_beside(const Model& model, const State& state, const BodySurface& surface,
                              const BladePath& path, int incision);

}  // namespace turgor::lattice
