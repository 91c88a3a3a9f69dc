// Rasterization of tetrahedra into voxels that visits each voxel center exactly once. Corners are integers
// (fractions of a voxel), so that the planes of all faces are exact in double. A center on a face belongs to
// the tetrahedron that a shift by (ε, ε², ε³) enters. Tetrahedra that share faces therefore leave no gaps and
// share no voxel.
#pragma once

#include <algorithm>
#include <array>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Axes along which the six Kuhn tetrahedra walk from (0,0,0) to (1,1,1).
constexpr std::array<Int3, 6> kKuhnPaths = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr Int3 unit_step(int axis) { return {axis == 0, axis == 1, axis == 2}; }
/// The same for an index that is not a compile-time constant, because the table is not available on a GPU.
constexpr Int3 kuhn_path(int tet) {
  const int first = tet / 2, low = first == 0 ? 1 : 0, high = first == 2 ? 1 : 2;
  return tet % 2 == 0 ? Int3{first, low, high} : Int3{first, high, low};
}
/// Corners of a tetrahedron in the order of its path.
constexpr std::array<Int3, 4> kuhn_corners(Int3 cell, int tet) {
  const Int3 path = kuhn_path(tet);
  const Int3 first = cell + unit_step(path.x), second = first + unit_step(path.y);
  return {cell, first, second, second + unit_step(path.z)};
}

/// Index of the tetrahedron of a cell that contains a point, from its coordinates in the cell; ties as in the
/// rasterizer.
template <class T>
constexpr int kuhn_tet_at(Vec<T> p) {
  if (p.x >= p.y) return p.y >= p.z ? 0 : p.x >= p.z ? 1 : 4;
  return p.x >= p.z ? 2 : p.y >= p.z ? 3 : 5;
}
/// Barycentric weights of a point in the cell, in the order of the path.
TURGOR_HD inline std::array<float, 4> path_weights(int tet, Vec3 p) {
  const Int3 path = kuhn_path(tet);
  return {1 - p[path.x], p[path.x] - p[path.y], p[path.y] - p[path.z], p[path.z]};
}

/// GCC otherwise does not inline the functions below, and rasterization takes a third longer.
#if defined(__GNUC__)
#define TURGOR_INLINE [[gnu::always_inline]] inline
#else
#define TURGOR_INLINE inline
#endif

/// Voxels that may be visited, and the fixed-point scale: 1 << bits units per voxel. Corners of one
/// tetrahedron must be less than kLargestExtent units apart along each axis.
struct RasterWindow {
  Int3 low, high;  // voxels, half-open range
  int bits = 10;
  double handedness = 1;  // -1 if the voxel axes are mirrored relative to the lattice's
};
constexpr double kLargestExtent = 1 << 16;  // keeps products of three differences below 2⁵³

/// A deformed tetrahedron: the map from a voxel to the cell's own coordinates.
struct DeformedTet {
  Vec3d rows[3];   // rows · (v − first) / det = cell coordinates, in [0, 1]
  double det = 0;  // six times the volume [units³]; not positive if inverted
  Int3 first;      // position of the first corner [units]
  Int3 low, high;  // bounding box [units]
};

template <int Tet>
TURGOR_INLINE TURGOR_HD DeformedTet deform_tet(const std::array<Int3, 4>& position, double handedness) {
  constexpr Int3 path = kKuhnPaths[Tet];
  DeformedTet tet{.rows = {}, .det = 0, .first = position[0], .low = {}, .high = {}};
  tet.low = min(min(position[0], position[1]), min(position[2], position[3]));
  tet.high = max(max(position[0], position[1]), max(position[2], position[3]));
  Vec3d edge[3];  // images of the three cell axes
  edge[path.x] = Vec3d(position[1] - position[0]);
  edge[path.y] = Vec3d(position[2] - position[1]);
  edge[path.z] = Vec3d(position[3] - position[2]);
  tet.rows[0] = cross(edge[1], edge[2]) * handedness;
  tet.rows[1] = cross(edge[2], edge[0]) * handedness;
  tet.rows[2] = cross(edge[0], edge[1]) * handedness;
  tet.det = dot(edge[0], tet.rows[0]);
  return tet;
}

/// A linear function that is not negative inside: its gradient is `slope` per unit.
struct Halfspace {
  Vec3d slope;
  double least;  // 0 if centers on the face belong to this side, else 1: values are integers
};
TURGOR_HD constexpr Halfspace halfspace(Vec3d inward) {
  const bool owns_face = inward.x > 0 || (inward.x == 0 && (inward.y > 0 || (inward.y == 0 && inward.z > 0)));
  return {inward, owns_face ? 0.0 : 1.0};
}

/// Coordinates of the CT for a raster walk: first node and cell size, in the visitor's unit.
struct RestFrame {
  Vec3d first_node, cell_size;
};
/// Unit: lattice nodes.
constexpr RestFrame kNodeUnits{.first_node = {0, 0, 0}, .cell_size = {1, 1, 1}};

/// Map from a voxel inside a deformed tetrahedron to its position in the CT.
struct VoxelToRest {
  Vec3 row[3];  // per voxel
  Vec3 base, first;

  TURGOR_INLINE TURGOR_HD VoxelToRest(const DeformedTet& tet, int bits, const RestFrame& rest, Int3 cell) {
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

/// Calls visit(voxel, position in the CT) for every voxel of the window whose center is inside.
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

  // inside: 1 ≥ a ≥ b ≥ c ≥ 0 for the cell's coordinates a, b, c in the order of the path, all times det
  const Vec3d &a = tet.rows[path.x], &b = tet.rows[path.y], &c = tet.rows[path.z];
  const Halfspace faces[4] = {halfspace(-a), halfspace(a - b), halfspace(b - c), halfspace(c)};
  const double unit = double(1 << bits), width = high.x - low.x;
  const double step[4] = {faces[0].slope.x * unit, faces[1].slope.x * unit, faces[2].slope.x * unit,
                          faces[3].slope.x * unit};

  const VoxelToRest place_of(tet, window.bits, rest, cell);
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++) {
      const Vec3d offset = Vec3d(Int3{low.x << bits, j << bits, k << bits} - tet.first);
      double value[4] = {dot(faces[0].slope, offset) + tet.det, dot(faces[1].slope, offset),
                         dot(faces[2].slope, offset), dot(faces[3].slope, offset)};
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

}  // namespace turgor
