// Skin forces and Hessians at nodes of a row, for many triangle corners at once. The laws are in
// element_energies.hpp and skin_exponential.hpp.
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/mechanics/patch_modes.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

using CornerSystems = Systems<kSkinLanes>;

/// Forces on the corners of triangles, by corner and axis [N].
struct TriangleForces {
  alignas(64) Real on[3][3][kSkinLanes];

  Vec3 get(int corner, int i) const { return {on[corner][0][i], on[corner][1][i], on[corner][2][i]}; }
};

/// Forces on the corners of the cells of patches, by corner and axis [N].
struct PatchForces {
  alignas(64) Real on[kCellCorners][3][kSkinLanes];

  Vec3 get(int corner, int i) const { return {on[corner][0][i], on[corner][1][i], on[corner][2][i]}; }
};

/// Slots of the corners of a cell from its lowest one, by parity of i.
struct CellOffsets {
  int of[2][kCellCorners];

  explicit CellOffsets(const Lattice& lattice) {
    for (int parity = 0; parity < 2; parity++)
      for (int c = 0; c < kCellCorners; c++) of[parity][c] = slot_offset(lattice, cell_corner(c), parity);
  }
};

struct SkinForces {
  SkinLaw law;
  FiberLaw fiber;
  Real rest_ratio, stiffness, amplification;
  ExponentialSkin exponential;
  Vec3 slope;  // of cells, as in SolidLaw
  CellOffsets offset;

  explicit SkinForces(const Model& model)
      : law(model.params.skin.law),
        fiber(fiber_law(model.params.skin)),
        rest_ratio(rest_area_ratio(model.params.skin)),
        stiffness(Real(model.params.skin.stiffness)),
        amplification(Real(model.params.skin.amplification)),
        exponential(exponential_skin(model.params.skin)),
        slope(solid_law(model.anatomy.lattice.spacing, 0).slope),
        offset(model.anatomy.lattice) {}

  /// Image of a unit vector d in the plane of a patch at its points, F d = d + ∇u d. `by`: of d.
  [[gnu::always_inline]] TURGOR_HD static AtPatchPoints<Vec3> fiber_of(const PatchDerivative& by,
                                                                       const CornerSums& sums,
                                                                       const CellTwists& twists, Vec3 d) {
    AtPatchPoints<Vec3> fiber = derivatives_of(by, sums, twists);
    fiber.mean += d;
    return fiber;
  }
  /// Stiffness that bounds what fibers differ by from their mean over the points of a patch [N/m]. `c`: mean
  /// products of the coefficients.
  ///
  /// A fiber f + δ at a point has the Hessian k c² (f + δ)(f + δ)ᵀ, at most 2 k c² (f fᵀ + |δ|² I). The bound
  /// of half of it suffices for Newton steps of a corner to lower the energy. In a twisted cell, the Hessian
  /// of the mean fibers alone lacks the stiffness across them: steps overshot at lips between stitches, and
  /// the sweeps diverged. Sums over the points keep loops in lanes from vectorizing, and take twice the time.
  [[gnu::always_inline]] TURGOR_HD Real stiffness_of_variance(const AtPatchPoints<Vec3>& f,
                                                              const AtPatchPoints<Vec3>& g,
                                                              const FiberProducts& c, Real area) const {
    const auto fiber_stiffness = [&](Vec3 mean, Real spread, Real rest) __attribute__((always_inline)) {
      const Real stretch = positive(fiber_length(mean) - rest);
      return fiber.stiffness * (1 + fiber.amplification / rest * stretch) * spread /
             (dot(mean, mean) + spread);
    };
    const Real of_f = variance(f), of_g = variance(g);
    const Real fibers = c.along * fiber_stiffness(f.mean, of_f, fiber.rest_along) +
                        c.across * fiber_stiffness(g.mean, of_g, fiber.rest_across);
    return 3 * area * (fibers + 2 * fiber.shear * (c.along * of_g + c.across * of_f));
  }
  /// System of a patch at corner `at` of its cell. `d`: displacements of the corners of the cell relative to
  /// one of them [m].
  [[gnu::always_inline]] TURGOR_HD NodeSystem patch_system(const Vec3 (&d)[kCellCorners], int at,
                                                           const SkinPatch& p) const {
    const AtPatchPoints<Vec3> products = point_products(p);
    const CornerSums sums = corner_sums(d);
    const CellTwists twists = cell_twists(d);
    // fibers, and derivatives of the corner's shape function along them
    const PatchDerivative by_along = patch_derivative(p, products, p.along, slope),
                          by_across = patch_derivative(p, products, p.across, slope);
    const AtPatchPoints<Vec3> f = fiber_of(by_along, sums, twists, p.along),
                              g = fiber_of(by_across, sums, twists, p.across);
    const AtPatchPoints<Real> along = derivatives_of_shape(by_along, at),
                              across = derivatives_of_shape(by_across, at);
    // force
    NodeSystem s;
    const Real area = p.area / kPatchPoints;
    const auto gradient = [&](int n) __attribute__((always_inline)) {
      return skin_fibers_gradient(f.at(n), g.at(n), along.at(n), across.at(n), area, fiber);
    };
    s.f -= gradient(0) + gradient(1) + gradient(2) + gradient(3);  // loops in lanes do not vectorize
    // Hessian
    const FiberProducts c{mean_product(along, along), mean_product(along, across),
                          mean_product(across, across)};
    add_skin_fibers_hessian(s, f.mean, g.mean, c, p.area, fiber);
    add_isotropic(s, stiffness_of_variance(f, g, c, p.area));
    return s;
  }
  /// System of one corner of a patch.
  TURGOR_HD NodeSystem gather(const PatchCorners& c, int i, const NodeArrays& n) const {
    const int own = c.cell[i] + offset.of[c.parity[i]][c.at[i]];
    const Vec3 u0 = n.u(own);
    Vec3 d[kCellCorners];
    for (int q = 0; q < kCellCorners; q++) d[q] = n.u(c.cell[i] + offset.of[c.parity[i]][q]) - u0;
    return patch_system(d, c.at[i], patch_of(c, i));
  }
  TURGOR_HD static SkinPatch patch_of(const PatchCorners& c, int i) {
    return {.cell = c.cell[i],
            .point = {c.point[0][i], c.point[1][i], c.point[2][i]},
            .reach1 = {c.reach1[0][i], c.reach1[1][i], c.reach1[2][i]},
            .reach2 = {c.reach2[0][i], c.reach2[1][i], c.reach2[2][i]},
            .along = {c.along[0][i], c.along[1][i], c.along[2][i]},
            .across = {c.across[0][i], c.across[1][i], c.across[2][i]},
            .area = c.area[i]};
  }
  /// Forces of a patch on all corners of its cell: out(corner, force). `d`: as in patch_system.
  template <class Out>
  [[gnu::always_inline]] void patch_forces(const Vec3 (&d)[kCellCorners], const SkinPatch& patch,
                                           const Out& out) const {
    const AtPatchPoints<Vec3> products = point_products(patch);
    const CornerSums sums = corner_sums(d);
    const CellTwists twists = cell_twists(d);
    const PatchDerivative by_along = patch_derivative(patch, products, patch.along, slope),
                          by_across = patch_derivative(patch, products, patch.across, slope);
    const AtPatchPoints<Vec3> f = fiber_of(by_along, sums, twists, patch.along),
                              g = fiber_of(by_across, sums, twists, patch.across);
    // stresses of one fiber at a point, times the area
    const Real area = patch.area / kPatchPoints;
    const auto stress = [&](Vec3 own, Vec3 other, Real rest) __attribute__((always_inline)) {
      return own * fiber_stress_factor(own, rest, fiber.stiffness * area, fiber.amplification) +
             other * (fiber.shear * area * dot(own, other));
    };
    const auto along = [&](int n) __attribute__((always_inline)) {
      return stress(f.at(n), g.at(n), fiber.rest_along);
    };
    const auto across = [&](int n) __attribute__((always_inline)) {
      return stress(g.at(n), f.at(n), fiber.rest_across);
    };
    const AtPatchPoints<Vec3> p = signed_sums(along(0), along(1), along(2), along(3)),
                              q = signed_sums(across(0), across(1), across(2), across(3));
    // forces
    TURGOR_UNROLL
    for (int c = 0; c < kCellCorners; c++)
      out(c, -(sum_of_products(p, derivatives_of_shape(by_along, c)) +
               sum_of_products(q, derivatives_of_shape(by_across, c))));
  }

  /// System of a corner at its own node; the edges start there.
  TURGOR_HD NodeSystem fiber_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    add_skin_fiber(s, edge1, edge2, {c.along[0][i], c.along[1][i], c.along[2][i]},
                   {c.across[0][i], c.across[1][i], c.across[2][i]}, c.area[i], fiber);
    return s;
  }
  TURGOR_HD NodeSystem area_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    const Real rest = rest_ratio * c.area[i];
    add_skin_area(s, {}, edge1, edge2, rest, stiffness / rest, amplification);
    return s;
  }
  TURGOR_HD NodeSystem exponential_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    add_skin_exponential(s, edge1, edge2, {c.along[0][i], c.along[1][i], c.along[2][i]},
                         {c.across[0][i], c.across[1][i], c.across[2][i]}, c.area[i], exponential);
    return s;
  }
  /// Growth of the exponents around one corner that moves by d.
  TURGOR_HD Real growth(const SkinCorners& c, int i, const NodeArrays& n, Vec3 d) const {
    const Vec3 u0 = n.u(c.vertex[0][i]);
    const auto edge = [&](int q) {
      return Vec3{c.edge[q - 1][0][i], c.edge[q - 1][1][i], c.edge[q - 1][2][i]} + (n.u(c.vertex[q][i]) - u0);
    };
    return skin_exponent_growth(edge(1), edge(2), {c.along[0][i], c.along[1][i], c.along[2][i]},
                                {c.across[0][i], c.across[1][i], c.across[2][i]}, exponential, d);
  }
  /// System of one corner.
  TURGOR_HD NodeSystem gather(const SkinCorners& c, int i, const NodeArrays& n) const {
    const Vec3 u0 = n.u(c.vertex[0][i]);
    const auto edge = [&](int q) {
      return Vec3{c.edge[q - 1][0][i], c.edge[q - 1][1][i], c.edge[q - 1][2][i]} + (n.u(c.vertex[q][i]) - u0);
    };
    if (law == SkinLaw::kExponential) return exponential_system(c, i, edge(1), edge(2));
    return law == SkinLaw::kFiber ? fiber_system(c, i, edge(1), edge(2))
                                  : area_system(c, i, edge(1), edge(2));
  }
  /// Systems of all corners of a batch.
  void gather(const SkinCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
  void gather(const PatchCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
  /// Forces on all corners of at most kSkinLanes triangles, without Hessians.
  void compute_forces(std::span<const SkinTriangle> triangles, const NodeArrays& nodes,
                      TriangleForces& out) const;
  /// The same for at most kSkinLanes patches.
  void compute_forces(std::span<const SkinPatch> patches, const Lattice& lattice, const NodeArrays& nodes,
                      PatchForces& out) const;
};

/// Corners of skin by node, as plain pointers for host and device (Skin, VbdTables, Cuts::skin_cut).
struct SkinView {
  const int *nodes, *corner_begin, *row_begin, *lanes_begin;  // null without skin
  const Vec3* prestress_force;
  const SkinCorners* corners;
  const PatchCorners* patches;   // instead of `corners`; null without patches
  const std::uint8_t* skin_cut;  // by triangle or patch

  TURGOR_HD bool is_cut(int batch, int lane) const {
    return skin_cut[patches ? patches[batch].patch[lane] : corners[batch].triangle[lane]] != 0;
  }
};
inline SkinView skin_view(const Model& model, const Cuts& cuts) {
  const Skin& skin = model.anatomy.skin;
  const VbdTables& vbd = model.vbd;
  return {skin.nodes.data(),
          vbd.corner_begin.data(),
          skin.row_begin.data(),
          vbd.lanes_begin.data(),
          model.prestress_force.data(),
          vbd.corners.data(),
          skin.patches.empty() ? nullptr : vbd.patch_corners.data(),
          cuts.skin_cut.data()};
}

/// Adds prestress and the uncut elements of skin node `at` of a half row. `system_of(batch, lane)`: system
/// of a corner.
template <class SystemOf>
TURGOR_HD inline void add_skin_corners(const SkinView& v, int row, int at, NodeSystem& s,
                                       const SystemOf& system_of) {
  s.f -= v.prestress_force[at];
  const int first = v.corner_begin[v.row_begin[row]];
  for (int c = v.corner_begin[at]; c < v.corner_begin[at + 1]; c++) {
    const int batch = v.lanes_begin[row] + (c - first) / kSkinLanes, lane = (c - first) % kSkinLanes;
    if (!v.is_cut(batch, lane)) add(s, system_of(batch, lane));
  }
}

/// Largest growth of the exponents of the uncut triangles of skin node `at` of a half row that moves by d.
TURGOR_HD inline Real largest_growth(const SkinView& v, const SkinForces& forces, const NodeArrays& n,
                                     int row, int at, Vec3 d) {
  const int first = v.corner_begin[v.row_begin[row]];
  Real most = 0;
  for (int c = v.corner_begin[at]; c < v.corner_begin[at + 1]; c++) {
    const SkinCorners& corners = v.corners[v.lanes_begin[row] + (c - first) / kSkinLanes];
    const int lane = (c - first) % kSkinLanes;
    if (v.skin_cut[corners.triangle[lane]]) continue;
    const Real growth = forces.growth(corners, lane, n, d);
    most = growth > most ? growth : most;
  }
  return most;
}
/// Stiffens a system so that its Newton step is this share of what it was.
///   (I + c H) Δ = r  →  (I + c H') Δ' = r,  I + c H' = (I + c H)/share
TURGOR_HD inline void shorten_step(NodeSystem& s, Real share, Real c) {
  const Real by = 1 / share;
  for (Real* entry : {&s.xx, &s.yy, &s.zz, &s.xy, &s.xz, &s.yz}) *entry *= by;
  add_isotropic(s, (by - 1) / nonzero(c));
}

/// Adds skin and prestress at the nodes of [slot, slot + count): store(node, load(node) + system).
template <class Load, class Store>
void for_skin_nodes(const Model& model, const Cuts& cuts, const NodeArrays& n, const SkinForces& forces,
                    int slot, int count, const Load& load, const Store& store) {
  const SkinView skin = skin_view(model, cuts);
  const int row = slot / model.anatomy.lattice.half;
  CornerSystems systems;
  int gathered = -1;  // index of the batch in `systems`
  const int* end = skin.nodes + skin.row_begin[row + 1];
  const int* node = std::lower_bound(skin.nodes + skin.row_begin[row], end, slot);
  for (; node != end && *node < slot + count; node++) {
    NodeSystem s = load(*node);
    add_skin_corners(skin, row, int(node - skin.nodes), s, [&](int batch, int lane) {
      if (batch != gathered) {
        if (skin.patches)
          forces.gather(skin.patches[batch], n, systems);
        else
          forces.gather(skin.corners[batch], n, systems);
        gathered = batch;
      }
      return systems.get(lane);
    });
    store(*node, s);
  }
}

}  // namespace turgor::lattice
