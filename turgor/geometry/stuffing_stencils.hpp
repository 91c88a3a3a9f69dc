// Stencils of isosurface stuffing: the inner region of one lattice tetrahedron that the surface crosses,
// split into one to three tetrahedra. The split of a face depends only on that face, so both neighbors agree.
// Internal to stuffing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/geometry/bcc_lattice.hpp"

namespace turgor::stuffing {

/// Side of a lattice point.
enum class Side : std::int8_t { kInside, kOnSurface, kOutside };

/// Corner of a resulting tetrahedron: a lattice point, or the cut on the edge from an inside point to an
/// outside one (to = -1 for a lattice point).
struct Corner {
  std::int64_t point = -1, to = -1;

  friend auto operator<=>(const Corner&, const Corner&) = default;
};

struct LatticeTet {
  std::array<BccPoint, 4> point;
  std::array<std::int64_t, 4> id;
  std::array<Side, 4> side;
};

/// Appends the inner region, four corners per tetrahedron in SolidMesh's order.
void append_inside(const LatticeTet& tet, std::vector<Corner>& corners);

}  // namespace turgor::stuffing
