// The body-centred cubic lattice: the corners of a grid of cubes (grid 0) and their centres (grid 1), joined
// by long edges along the axes within a grid and by short ones between the grids. Every long edge of grid 0
// and a long edge of grid 1 that crosses beside it make a tetrahedron; these fill space.
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
  Int3 place;
  int grid = 0;
};

constexpr std::int64_t grid_points(const BccLattice& lattice) {
  return std::int64_t(lattice.count.x) * lattice.count.y * lattice.count.z;
}
constexpr std::int64_t point_count(const BccLattice& lattice) { return 2 * grid_points(lattice); }

constexpr std::int64_t point_id(const BccLattice& lattice, BccPoint p) {
  const Int3 n = lattice.count;
  return ((std::int64_t(p.grid) * n.z + p.place.z) * n.y + p.place.y) * n.x + p.place.x;
}
constexpr BccPoint point_of(const BccLattice& lattice, std::int64_t id) {
  const Int3 n = lattice.count;
  const int x = int(id % n.x), y = int(id / n.x % n.y), z = int(id / n.x / n.y % n.z);
  return {{x, y, z}, int(id / n.x / n.y / n.z)};
}
constexpr Vec3d place_of(const BccLattice& lattice, BccPoint p) {
  return lattice.origin + (Vec3d(p.place) + Vec3d{0.5, 0.5, 0.5} * double(p.grid)) * lattice.size;
}
constexpr bool contains(const BccLattice& lattice, BccPoint p) {
  const Int3 q = p.place, n = lattice.count;
  return q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x < n.x && q.y < n.y && q.z < n.z;
}

/// The neighbours of a point whose ids are higher: along three long edges, and from grid 0 along eight short
/// ones. Some may lie beyond the lattice.
struct BccNeighbors {
  int count;
  std::array<BccPoint, 11> point;
};
constexpr BccNeighbors higher_neighbors(BccPoint p) {
  BccNeighbors result{p.grid == 0 ? 11 : 3, {}};
  for (int axis = 0; axis < 3; axis++) {
    result.point[std::size_t(axis)] = p;
    result.point[std::size_t(axis)].place[axis]++;
  }
  for (int corner = 0; p.grid == 0 && corner < 8; corner++)
    result.point[std::size_t(3 + corner)] = {
        {p.place.x - (corner & 1), p.place.y - (corner >> 1 & 1), p.place.z - (corner >> 2)}, 1};
  return result;
}

/// The four tetrahedra around the long edge from a point of grid 0 along an axis, each in SolidMesh's order.
/// Some corners may lie beyond the lattice.
constexpr std::array<std::array<BccPoint, 4>, 4> tetrahedra_around(Int3 place, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::array<BccPoint, 4> ring;  // the centres around the edge, counter-clockwise seen from its end
  for (int i = 0; i < 4; i++) {
    BccPoint& center = ring[std::size_t(i)];
    center = {place, 1};
    center.place[u] -= i == 1 || i == 2;
    center.place[v] -= i == 2 || i == 3;
  }
  Int3 end = place;
  end[axis]++;
  std::array<std::array<BccPoint, 4>, 4> tets;
  for (std::size_t i = 0; i < 4; i++) tets[i] = {{{place, 0}, ring[i], ring[(i + 1) % 4], {end, 0}}};
  return tets;
}

}  // namespace turgor
