#include "turgor/models/lattice/mechanics/skin_forces.hpp"

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

/// Triangles side by side, with their sides as they are now; the first again behind the last.
struct TriangleLanes {
  alignas(64) Real edge[2][3][kSkinLanes], along[3][kSkinLanes], across[3][kSkinLanes], area[kSkinLanes];

  TriangleLanes(std::span<const SkinTriangle> triangles, const NodeArrays& n) {
    for (std::size_t i = 0; i < kSkinLanes; i++) {
      const SkinTriangle& t = triangles[i < triangles.size() ? i : 0];
      const Vec3 here = n.u(t.vertex.x), edge1 = t.edge1 + (n.u(t.vertex.y) - here),
                 edge2 = t.edge2 + (n.u(t.vertex.z) - here);
      for (int axis = 0; axis < 3; axis++) {
        edge[0][axis][i] = edge1[axis], edge[1][axis][i] = edge2[axis];
        along[axis][i] = t.along[axis], across[axis][i] = t.across[axis];
      }
      area[i] = t.area;
    }
  }
  static Vec3 vec(const Real (&field)[3][kSkinLanes], int i) {
    return {field[0][i], field[1][i], field[2][i]};
  }
};

}  // namespace

void SkinForces::gather(const SkinCorners& corners, const NodeArrays& nodes,
                        CornerSystems& __restrict out) const {
  const Places places(corners, nodes);
  const SkinForces by = *this;  // a copy that the stores below cannot reach
  if (law == SkinLaw::kFiber) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      out.set(i, by.of_fibers(corners, i, places.edge(corners, 1, i), places.edge(corners, 2, i)));
    return;
  }
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++)
    out.set(i, by.of_area(corners, i, places.edge(corners, 1, i), places.edge(corners, 2, i)));
}

void SkinForces::find(std::span<const SkinTriangle> triangles, const NodeArrays& nodes,
                      TriangleForces& __restrict out) const {
  const TriangleLanes t(triangles, nodes);
  const SkinForces by = *this;  // a copy that the stores below cannot reach
  const auto set = [&](int i, const CornerForces& f) {
#pragma GCC unroll 3
    for (int c = 0; c < 3; c++)
      out.on[c][0][i] = f.on[c].x, out.on[c][1][i] = f.on[c].y, out.on[c][2][i] = f.on[c].z;
  };
  if (law == SkinLaw::kFiber) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      set(i, skin_fiber_forces(t.vec(t.edge[0], i), t.vec(t.edge[1], i), t.vec(t.along, i),
                               t.vec(t.across, i), t.area[i], by.fiber));
    return;
  }
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++) {
    const Real rest = by.rest_ratio * t.area[i];
    set(i, skin_area_forces(t.vec(t.edge[0], i), t.vec(t.edge[1], i), rest, by.stiffness / rest,
                            by.amplification));
  }
}

}  // namespace turgor::lattice
