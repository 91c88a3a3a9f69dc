// Triangulated surface swept by a blade, and its intersections with the edges of a body.
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
  Vec3d normal;                // points to the blade's right side
  double along[3];             // arc length along the path, per corner [m]
  Box box;
};

struct BladeSheet {
  std::vector<SheetTriangle> triangles;
  Box box;
};

/// Sweeps the blade from `margin` above the skin down to its edge. `tilt` is the angle from `into`, positive
/// to the right seen from outside [radians]. The sheet is shifted to the left and extended by `epsilon`, so
/// that no node of a regular lattice lies exactly in it or on its border.
BladeSheet sweep_blade(const BladePath& path, double tilt, double margin, double epsilon);

/// Adds a triangle with the arc length of each corner [m], unless it has no area.
void add_triangle(BladeSheet& sheet, const std::array<Vec3d, 3>& corner, const std::array<double, 3>& along);
/// Adds two triangles between the segments corner[0]–corner[1] and corner[2]–corner[3]. All their corners get
/// the arc length `along` [m].
void add_strip(BladeSheet& sheet, const std::array<Vec3d, 4>& corner, double along);

/// Intersection of the segment from `a` to `b` with the sheet: `fraction` of the segment, arc length `along`
/// the path [m], and whether b lies to the right.
struct SheetCrossing {
  double fraction = 0, along = 0;
  bool rightward = false;
};
std::optional<SheetCrossing> cross_sheet(const BladeSheet& sheet, std::span<const int> triangles, Vec3d a,
                                         Vec3d b);

/// Indices of the triangles whose bounding boxes overlap `box`.
void triangles_near(const BladeSheet& sheet, const Box& box, std::vector<int>& found);

/// Finds all edges of the body that cross the sheet, for BladePath::edges, fine_edges and lines. Edges that
/// are already cut are omitted.
void find_edges(const Model& model, const State& state, const BladeSheet& sheet, const HaloExchange* halo,
                BladePath& path);

}  // namespace turgor::lattice
