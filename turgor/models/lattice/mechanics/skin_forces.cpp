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

/// Batch of patches, and displacements of the corners of their cells relative to the first. Lanes after the
/// last patch repeat the first one.
struct PatchLanes {
  alignas(64) Real d[kCellCorners][3][kSkinLanes], point[3][kSkinLanes], reach1[3][kSkinLanes],
      reach2[3][kSkinLanes], along[3][kSkinLanes], across[3][kSkinLanes], area[kSkinLanes];

  PatchLanes(std::span<const SkinPatch> patches, const Lattice& l, const CellOffsets& offset,
             const NodeArrays& n) {
    for (std::size_t i = 0; i < kSkinLanes; i++) {
      const SkinPatch& p = patches[i < patches.size() ? i : 0];
      const int parity = slot_node(l, p.cell).x & 1;
      const Vec3 first = n.u(p.cell);
      for (int c = 0; c < kCellCorners; c++) {
        const Vec3 u = n.u(p.cell + offset.of[parity][c]) - first;
        d[c][0][i] = u.x, d[c][1][i] = u.y, d[c][2][i] = u.z;
      }
      for (int axis = 0; axis < 3; axis++) {
        point[axis][i] = p.point[axis], reach1[axis][i] = p.reach1[axis], reach2[axis][i] = p.reach2[axis];
        along[axis][i] = p.along[axis], across[axis][i] = p.across[axis];
      }
      area[i] = p.area;
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

void SkinForces::gather(const PatchCorners& corners, const NodeArrays& nodes,
                        CornerSystems& __restrict out) const {
  // the next batch: half rows have few of them, so that the processor would begin to read too late
  for (std::size_t byte = 0; byte < sizeof corners; byte += 64)
    __builtin_prefetch(reinterpret_cast<const char*>(&corners + 1) + byte);
  // displacements of the corners of the cells, relative to the node
  alignas(64) Real u[kCellCorners][3][kSkinLanes];
  for (int q = 0; q < kCellCorners; q++)
    for (int i = 0; i < kSkinLanes; i++) {
      const int slot = corners.cell[i] + offset.of[corners.parity[i]][q];
      u[q][0][i] = nodes.ux[slot], u[q][1][i] = nodes.uy[slot], u[q][2][i] = nodes.uz[slot];
    }
  // systems
  const SkinForces by = *this;  // local copy, so that stores cannot alias it
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++) {
    const Vec3 first{u[0][0][i], u[0][1][i], u[0][2][i]};
    Vec3 d[kCellCorners];
    for (int q = 0; q < kCellCorners; q++) d[q] = Vec3{u[q][0][i], u[q][1][i], u[q][2][i]} - first;
    out.set(i, by.patch_system(d, corners.at[i], patch_of(corners, i)));
  }
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

void SkinForces::compute_forces(std::span<const SkinPatch> patches, const Lattice& lattice,
                                const NodeArrays& nodes, PatchForces& __restrict out) const {
  const PatchLanes lanes(patches, lattice, offset, nodes);
  const SkinForces by = *this;  // local copy, so that stores cannot alias it
  TURGOR_LANES
  for (int i = 0; i < kSkinLanes; i++) {
    const SkinPatch patch{.cell = 0,
                          .point = lanes.vec(lanes.point, i),
                          .reach1 = lanes.vec(lanes.reach1, i),
                          .reach2 = lanes.vec(lanes.reach2, i),
                          .along = lanes.vec(lanes.along, i),
                          .across = lanes.vec(lanes.across, i),
                          .area = lanes.area[i]};
    const Vec3 d[kCellCorners] = {lanes.vec(lanes.d[0], i), lanes.vec(lanes.d[1], i),
                                  lanes.vec(lanes.d[2], i), lanes.vec(lanes.d[3], i),
                                  lanes.vec(lanes.d[4], i), lanes.vec(lanes.d[5], i),
                                  lanes.vec(lanes.d[6], i), lanes.vec(lanes.d[7], i)};
    by.patch_forces(
        d, patch, [&](int c, Vec3 f) __attribute__((always_inline)) {
          out.on[c][0][i] = f.x, out.on[c][1][i] = f.y, out.on[c][2][i] = f.z;
        });
  }
}

}  // namespace turgor::lattice
