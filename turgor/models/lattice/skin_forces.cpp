#include "turgor/models/lattice/skin_forces.hpp"

namespace turgor::lattice {

namespace {

/// Displacements of the corners' three nodes, by axis [m].
struct Places {
  alignas(64) Real u[3][3][kSkinLanes];

  Places(const SkinCorners& corners, const NodeArrays& n) {
    for (int q = 0; q < 3; q++)
      for (int i = 0; i < kSkinLanes; i++) {
        const int slot = corners.vertex[q][i];
        u[q][0][i] = n.ux[slot], u[q][1][i] = n.uy[slot], u[q][2][i] = n.uz[slot];
      }
  }
  /// From the corner's own node to another.
  Vec3 edge(const SkinCorners& corners, int other, int i) const {
    const auto along = [&](int axis) {
      return corners.edge[other - 1][axis][i] + (u[other][axis][i] - u[0][axis][i]);
    };
    return {along(0), along(1), along(2)};
  }
};

}  // namespace

void SkinForces::gather(const SkinCorners& corners, const NodeArrays& nodes,
                        CornerSystems& __restrict out) const {
  const Places places(corners, nodes);
  const SkinForces by = *this;  // a copy that the stores below cannot reach
  if (law == SkinLaw::kFibre) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      out.set(i, by.of_fibres(corners, i, places.edge(corners, 1, i), places.edge(corners, 2, i)));
    return;
  }
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++)
    out.set(i, by.of_area(corners, i, places.edge(corners, 1, i), places.edge(corners, 2, i)));
}

}  // namespace turgor::lattice
