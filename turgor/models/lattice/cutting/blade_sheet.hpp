// The surface that a blade sweeps, as triangles, and where edges of a body cross it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {

struct SheetTriangle {
  Vec3d corner, side1, side2;  // [m]
  Vec3d normal;                // towards the right side of the blade
  double along[3];             // of its corners, on the path [m]
  Box box;
};

struct BladeSheet {
  std::vector<SheetTriangle> triangles;
  Box box;
};

/// From `margin` above the skin down to the blade's edge. `tilt` from `into`, towards the right seen from
/// outside [radians]. A hair aside and a hair larger, so that nothing regular lies in it or ends with it.
BladeSheet sweep_blade(const BladePath& path, double tilt, double margin, double hair);

/// Adds a strip between two lines: from the first two corners, further on, to the last two, which lie beside
/// them. `along` is that of all of it [m].
void add_strip(BladeSheet& sheet, const std::array<Vec3d, 4>& corner, double along);

/// Where the way from `a` to `b` crosses one of the triangles.
struct SheetCrossing {
  double fraction = 0, along = 0;
  bool rightward = false;
};
std::optional<SheetCrossing> cross_sheet(const BladeSheet& sheet, std::span<const int> triangles, Vec3d a,
                                         Vec3d b);

/// The triangles whose boxes meet this one.
void triangles_near(const BladeSheet& sheet, const Box& box, std::vector<int>& found);

/// All edges of the body that the sheet crosses, for BladePath::edges and fine_edges; those that are cut
/// already are left out.
void find_edges(const Model& model, const State& state, const BladeSheet& sheet, const HaloExchange* halo,
                BladePath& path);

}  // namespace turgor::lattice
