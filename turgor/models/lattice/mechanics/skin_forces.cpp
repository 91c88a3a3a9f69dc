#include "turgor/models/lattice/mechanics/skin_forces.hpp"

namespace turgor::lattice {

namespace {

/// Displacements of the nodes of a batch of corners, by axis [m].
struct CornerDisplacements {
  alignas(64) Real u[3][3][kSkinLanes];

  CornerDisplacements(const SkinCorners& corners, const NodeArrays& n) {
    for (int q = 0; q < 3; q++)
      for (int i = 0; i < kSkinLanes; i++) {
        const int slot = corners.vertex[q][i];
        u[q][0][i] = n.ux[slot], u[q][1][i] = n.uy[slot], u[q][2][i] = n.uz[slot];
      }
  }
  /// Deformed edge from the corner's own node to another.
  Vec3 edge(const SkinCorners& corners, int other, int i) const {
    const auto along = [&](int axis) {
      return corners.edge[other - 1][axis][i] + (u[other][axis][i] - u[0][axis][i]);
    };
    return {along(0), along(1), along(2)};
  }
};

/// Batch of deformed triangles. Lanes after the last triangle repeat the first one.
struct TriangleLanes {
  alignas(64) Real edge[2][3][kSkinLanes], along[3][kSkinLanes], across[3][kSkinLanes], area[kSkinLanes];

  TriangleLanes(std::span<const SkinTriangle> triangles, const NodeArrays& n) {
    for (std::size_t i = 0; i < kSkinLanes; i++) {
      const SkinTriangle& t = triangles[i < triangles.size() ? i : 0];
      const Vec3 u0 = n.u(t.vertex.x), edge1 = t.edge1 + (n.u(t.vertex.y) - u0),
                 edge2 = t.edge2 + (n.u(t.vertex.z) - u0);
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
  const CornerDisplacements displacements(corners, nodes);
  const SkinForces by = *this;  // local copy, so that stores cannot alias it
  if (law == SkinLaw::kFiber) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      out.set(i, by.fiber_system(corners, i, displacements.edge(corners, 1, i),
                                 displacements.edge(corners, 2, i)));
    return;
  }
  if (law == SkinLaw::kExponential) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      out.set(i, by.exponential_system(corners, i, displacements.edge(corners, 1, i),
                                       displacements.edge(corners, 2, i)));
    return;
  }
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++)
    out.set(i,
            by.area_system(corners, i, displacements.edge(corners, 1, i), displacements.edge(corners, 2, i)));
}

void SkinForces::compute_forces(std::span<const SkinTriangle> triangles, const NodeArrays& nodes,
                                TriangleForces& __restrict out) const {
  const TriangleLanes t(triangles, nodes);
  const SkinForces by = *this;  // local copy, so that stores cannot alias it
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
  if (law == SkinLaw::kExponential) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++)
      set(i, skin_exponential_forces(t.vec(t.edge[0], i), t.vec(t.edge[1], i), t.vec(t.along, i),
                                     t.vec(t.across, i), t.area[i], by.exponential));
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
