// Rasterising tetrahedra into voxels, each voxel centre exactly once. Corners are whole numbers (fractions of
// a voxel), so that the planes of all faces are exact in double; a centre on a face belongs to the
// tetrahedron whose inside a step by (ε, ε², ε³) reaches. Tetrahedra that share faces therefore leave no hole
// and share no voxel.
#pragma once

#include <algorithm>
#include <array>

#include "turgor/core/vec.hpp"

namespace turgor::lattice {

/// The axes along which the six Kuhn tetrahedra walk from (0,0,0) to (1,1,1).
constexpr std::array<Int3, 6> kKuhnPaths = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr Int3 unit_step(int axis) { return {axis == 0, axis == 1, axis == 2}; }
/// The same of a tetrahedron that is not known before: the table is not there on a GPU.
constexpr Int3 kuhn_path(int tet) {
  const int first = tet / 2, low = first == 0 ? 1 : 0, high = first == 2 ? 1 : 2;
  return tet % 2 == 0 ? Int3{first, low, high} : Int3{first, high, low};
}
/// The corners of a tetrahedron in the order of its path.
constexpr std::array<Int3, 4> kuhn_corners(Int3 cell, int tet) {
  const Int3 path = kuhn_path(tet);
  const Int3 first = cell + unit_step(path.x), second = first + unit_step(path.y);
  return {cell, first, second, second + unit_step(path.z)};
}

/// Which of a cell's tetrahedra holds a point, from its coordinates in the cell; ties as the rasteriser
/// breaks them.
template <class T>
constexpr int kuhn_tet_at(Vec<T> p) {
  if (p.x >= p.y) return p.y >= p.z ? 0 : p.x >= p.z ? 1 : 4;
  return p.x >= p.z ? 2 : p.y >= p.z ? 3 : 5;
}
/// Barycentric weights, in the order of the path, of a point in the cell.
TURGOR_HD inline std::array<float, 4> path_weights(int tet, Vec3 p) {
  const Int3 path = kuhn_path(tet);
  return {1 - p[path.x], p[path.x] - p[path.y], p[path.y] - p[path.z], p[path.z]};
}

/// GCC leaves the functions below out of line otherwise, and a walk takes a third longer.
#if defined(__GNUC__)
#define TURGOR_INLINE [[gnu::always_inline]] inline
#else
#define TURGOR_INLINE inline
#endif

/// The voxels that may be visited, and the fixed point: 1 << bits units a voxel. Corners of one tetrahedron
/// must be less than kLargestExtent units apart along each axis.
struct RasterWindow {
  Int3 low, high;  // voxels, half open
  int bits = 10;
  double handed = 1;  // -1 when voxel axes are mirrored against the lattice's
};
constexpr double kLargestExtent = 1 << 16;  // products of three differences stay below 2⁵³

/// A tetrahedron placed among the voxels: the way from a voxel to the cell's own coordinates.
struct DeformedTet {
  Vec3d rows[3];   // rows · (v − first) / det = coordinates in the cell, in [0, 1]
  double det = 0;  // six times the volume [units³]; not positive when turned inside out
  Int3 first;      // place of the first corner [units]
  Int3 low, high;  // bounds [units]
};

template <int Tet>
TURGOR_INLINE TURGOR_HD DeformedTet deform_tet(const std::array<Int3, 4>& place, double handed) {
  constexpr Int3 path = kKuhnPaths[Tet];
  DeformedTet tet{.rows = {}, .det = 0, .first = place[0], .low = {}, .high = {}};
  tet.low = min(min(place[0], place[1]), min(place[2], place[3]));
  tet.high = max(max(place[0], place[1]), max(place[2], place[3]));
  Vec3d edge[3];  // images of the cell's three axes
  edge[path.x] = Vec3d(place[1] - place[0]);
  edge[path.y] = Vec3d(place[2] - place[1]);
  edge[path.z] = Vec3d(place[3] - place[2]);
  tet.rows[0] = cross(edge[1], edge[2]) * handed;
  tet.rows[1] = cross(edge[2], edge[0]) * handed;
  tet.rows[2] = cross(edge[0], edge[1]) * handed;
  tet.det = dot(edge[0], tet.rows[0]);
  return tet;
}

/// A linear function that is not negative inside: `value` at the voxel in hand, `slope` a voxel.
struct Halfspace {
  Vec3d slope;
  double least;  // 0 when centres on the face belong to this side, else 1: values are whole numbers
};
TURGOR_HD constexpr Halfspace halfspace(Vec3d inward) {
  const bool owns_face = inward.x > 0 || (inward.x == 0 && (inward.y > 0 || (inward.y == 0 && inward.z > 0)));
  return {inward, owns_face ? 0.0 : 1.0};
}

/// Coordinates of the CT that a raster walk speaks of: first node and cell size, in whatever unit the visitor
/// wants.
struct RestFrame {
  Vec3d first_node, cell_size;
};
/// In nodes of the lattice.
constexpr RestFrame kInNodes{.first_node = {0, 0, 0}, .cell_size = {1, 1, 1}};

/// Where in the CT a voxel inside a tetrahedron of a cell comes from.
struct PlaceOfVoxel {
  Vec3 row[3];  // in steps of voxels
  Vec3 base, first;

  TURGOR_INLINE TURGOR_HD PlaceOfVoxel(const DeformedTet& tet, int bits, const RestFrame& rest, Int3 cell) {
    const double unit = double(1 << bits), inverse = unit / tet.det;
    for (int axis = 0; axis < 3; axis++) row[axis] = Vec3(tet.rows[axis] * (rest.cell_size[axis] * inverse));
    base = Vec3(rest.first_node + hadamard(Vec3d(cell), rest.cell_size));
    first = Vec3(tet.first) / Real(unit);
  }
  TURGOR_INLINE TURGOR_HD Vec3 operator()(Int3 voxel) const {
    const Vec3 d = Vec3(voxel) - first;
    return base + Vec3{dot(row[0], d), dot(row[1], d), dot(row[2], d)};
  }
};

/// Calls visit(voxel, place in the CT) for every voxel of the window whose centre is inside.
template <int Tet, class Visit>
TURGOR_INLINE TURGOR_HD void visit_voxels(const DeformedTet& tet, const RasterWindow& window,
                                          const RestFrame& rest, Int3 cell, const Visit& visit) {
  constexpr Int3 path = kKuhnPaths[Tet];
  const int up = (1 << window.bits) - 1, bits = window.bits;
  const Int3 low =
      max(window.low, Int3{(tet.low.x + up) >> bits, (tet.low.y + up) >> bits, (tet.low.z + up) >> bits});
  const Int3 high =
      min(window.high - Int3{1, 1, 1}, Int3{tet.high.x >> bits, tet.high.y >> bits, tet.high.z >> bits});
  if (low.x > high.x || low.y > high.y || low.z > high.z) return;

  // Inside: 1 ≥ a ≥ b ≥ c ≥ 0 for the cell's coordinates a, b, c in the order of the path, all times det.
  const Vec3d &a = tet.rows[path.x], &b = tet.rows[path.y], &c = tet.rows[path.z];
  const Halfspace faces[4] = {halfspace(-a), halfspace(a - b), halfspace(b - c), halfspace(c)};
  const double unit = double(1 << bits), width = high.x - low.x;
  const double step[4] = {faces[0].slope.x * unit, faces[1].slope.x * unit, faces[2].slope.x * unit,
                          faces[3].slope.x * unit};

  const PlaceOfVoxel place_of(tet, window.bits, rest, cell);
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++) {
      const Vec3d away = Vec3d(Int3{low.x << bits, j << bits, k << bits} - tet.first);
      double value[4] = {dot(faces[0].slope, away) + tet.det, dot(faces[1].slope, away),
                         dot(faces[2].slope, away), dot(faces[3].slope, away)};
      bool reached = true;
      for (int f = 0; f < 4; f++) {
        value[f] -= faces[f].least;
        reached &= std::max(value[f], value[f] + step[f] * width) >= 0;
      }
      if (!reached) continue;
      for (int i = low.x; i <= high.x; i++) {
        if ((value[0] >= 0) & (value[1] >= 0) & (value[2] >= 0) & (value[3] >= 0)) {
          const Int3 voxel{i, j, k};
          visit(voxel, place_of(voxel));
        }
        for (int f = 0; f < 4; f++) value[f] += step[f];
      }
    }
}

}  // namespace turgor::lattice
