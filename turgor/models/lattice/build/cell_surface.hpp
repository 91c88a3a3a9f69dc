// Surface of the body in the cells that contain it. The surface crosses each edge between a body node and a
// node outside at one point, where the CT passes the level of air. Planes through these points in the
// tetrahedra of a cell close at its faces, so neighbor cells leave no gap [Lorensen, Cline 1987; Doi, Koide
// 1991].
#pragma once

#include <array>
#include <functional>

#include "turgor/models/lattice/build/ct_part.hpp"
#include "turgor/models/lattice/build/surroundings.hpp"
#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Positions on an edge at which the body begins, as seen from its lower and from its upper node. Fractions
/// of the edge: 0 if the end is body, and 1 if all is air.
struct EdgeCrossing {
  float from_low = 0, from_high = 0;  // [1]
};
/// Crossing of the edge of a family that starts at a node of the whole body.
using CrossingOfEdge = std::function<EdgeCrossing(Int3, int)>;

/// Level of a CT above air. Between the centers of voxels it is linear along each axis; the voxels at an end
/// of the CT continue beyond it. Surroundings are air.
struct AirLevel {
  const CtSlab& ct;
  const Surroundings& surroundings;
  double air_max;  // [HU]

  double voxel(Int3 at) const;
  bool is_body(Int3 voxel_at) const { return voxel(voxel_at) >= 0; }
  double at(Vec3d voxels) const;  // from the corner of the first voxel
};
/// Crossing of an edge. The slab must hold the slices between its ends and one more on both sides.
EdgeCrossing cross_edge(const AirLevel& level, Int3 block, Int3 node, int family);

/// Surface of the body in a cell, as a parallelogram with the same vector area, center and second moments.
struct CellSurface {
  Int3 cell;            // lowest node
  Vec3 area;            // vector area, outward, along the axes of the lattice [m²]
  Vec3 center;          // from the lowest node [m]
  Vec3 reach1, reach2;  // the points center ± reach1 ± reach2 integrate quadratics exactly [m]
};

/// Surface in a cell, by its corners (bit 0 = x, 1 = y, 2 = z); no area without one. `first`: layer of
/// the whole body at which the layers of `cell` begin.
CellSurface surface_in_cell(Int3 cell, int first, Vec3d spacing, const std::array<bool, 8>& is_body_corner,
                            const CrossingOfEdge& crossing);

}  // namespace turgor::lattice
