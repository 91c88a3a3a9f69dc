// What isosurface stuffing makes of one lattice tetrahedron that the surface passes through: its inner part,
// cut into one to three tetrahedra. Shared faces are cut alike from both sides, because the cut of a face
// depends on that face alone. Internal to stuffing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/geometry/bcc_lattice.hpp"

namespace turgor::stuffing {

/// Where a lattice point lies.
enum class Side : std::int8_t { kInside, kOnSurface, kOutside };

/// A corner of a tetrahedron of the result: a lattice point, or where the surface cuts the edge from an
/// inside point to an outside one (to = -1 for a lattice point).
struct Corner {
  std::int64_t point = -1, to = -1;

  friend auto operator<=>(const Corner&, const Corner&) = default;
};

struct LatticeTet {
  std::array<BccPoint, 4> point;
  std::array<std::int64_t, 4> id;
  std::array<Side, 4> side;
};

/// Appends the inner part, four corners a tetrahedron in SolidMesh's order.
void append_inner_part(const LatticeTet& tet, std::vector<Corner>& corners);

}  // namespace turgor::stuffing
