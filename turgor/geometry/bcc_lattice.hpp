// Body-centered cubic (BCC) lattice: corners of a grid of cubes (grid 0) and their centers (grid 1). Long
// edges join neighbors of one grid along the axes, short edges join the two grids. Each long edge of grid 0
// and a long edge of grid 1 that passes it form a tetrahedron; these fill space.
#pragma once

#include <array>
#include <cstdint>

#include "turgor/core/vec.hpp"

namespace turgor {

struct BccLattice {
  Vec3d origin;  // of point (0, 0, 0) of grid 0 [m]
  double size;   // of a cube [m]
  Int3 count;    // points of each grid along x, y, z
};

struct BccPoint {
  Int3 index;
  int grid = 0;
};

constexpr std::int64_t grid_points(const BccLattice& lattice) {
  return std::int64_t(lattice.count.x) * lattice.count.y * lattice.count.z;
}
constexpr std::int64_t point_count(const BccLattice& lattice) { return 2 * grid_points(lattice); }

constexpr std::int64_t point_id(const BccLattice& lattice, BccPoint p) {
  const Int3 n = lattice.count;
  return ((std::int64_t(p.grid) * n.z + p.index.z) * n.y + p.index.y) * n.x + p.index.x;
}
constexpr BccPoint point_of(const BccLattice& lattice, std::int64_t id) {
  const Int3 n = lattice.count;
  const int x = int(id % n.x), y = int(id / n.x % n.y), z = int(id / n.x / n.y % n.z);
  return {{x, y, z}, int(id / n.x / n.y / n.z)};
}
constexpr Vec3d place_of(const BccLattice& lattice, BccPoint p) {
  return lattice.origin + (Vec3d(p.index) + Vec3d{0.5, 0.5, 0.5} * double(p.grid)) * lattice.size;
}
constexpr bool contains(const BccLattice& lattice, BccPoint p) {
  const Int3 q = p.index, n = lattice.count;
  return q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x < n.x && q.y < n.y && q.z < n.z;
}

/// Neighbors of a point with higher ids: along three long edges, and from grid 0 along eight short ones. Some
/// may be outside the lattice.
struct BccNeighbors {
  int count;
  std::array<BccPoint, 11> point;
};
constexpr BccNeighbors higher_neighbors(BccPoint p) {
  BccNeighbors result{p.grid == 0 ? 11 : 3, {}};
  for (int axis = 0; axis < 3; axis++) {
    result.point[std::size_t(axis)] = p;
    result.point[std::size_t(axis)].index[axis]++;
  }
  for (int corner = 0; p.grid == 0 && corner < 8; corner++)
    result.point[std::size_t(3 + corner)] = {
        {p.index.x - (corner & 1), p.index.y - (corner >> 1 & 1), p.index.z - (corner >> 2)}, 1};
  return result;
}

/// The four tetrahedra around the long edge from a point of grid 0 along an axis, in SolidMesh's order. Some
/// corners may be outside the lattice.
constexpr std::array<std::array<BccPoint, 4>, 4> tetrahedra_around(Int3 index, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::array<BccPoint, 4> ring;  // centers around the edge, counter-clockwise seen from its end
  for (int i = 0; i < 4; i++) {
    BccPoint& center = ring[std::size_t(i)];
    center = {index, 1};
    center.index[u] -= i == 1 || i == 2;
    center.index[v] -= i == 2 || i == 3;
  }
  Int3 end = index;
  end[axis]++;
  std::array<std::array<BccPoint, 4>, 4> tets;
  for (std::size_t i = 0; i < 4; i++) tets[i] = {{{index, 0}, ring[i], ring[(i + 1) % 4], {end, 0}}};
  return tets;
}

}  // namespace turgor
