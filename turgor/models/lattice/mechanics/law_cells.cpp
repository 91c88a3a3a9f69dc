#include "turgor/models/lattice/mechanics/law_cells.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/mechanics/ogden.hpp"

namespace turgor::lattice {

namespace {

/// Calls f with the law as a type, so that loops over cells know it.
template <class F>
void with_law(const CellLawView& laws, const F& f) {
  switch (laws.energy) {
    case SolidEnergy::kNeoHookean:
      return f(NeoHookeanLaw{});
    case SolidEnergy::kExponential:
      if (laws.fiber != nullptr) return f(FiberedExponentialLaw{});
      return f(ExponentialLaw{});
    case SolidEnergy::kOgden:
      return f(OgdenLaw{});
  }
}

template <class Law>
[[gnu::always_inline]] inline CellModuli moduli_of(const CellLawView& laws, int slot, Real young) {
  CellModuli m = laws.moduli(slot, young);
  if constexpr (Law::kHasFibers) laws.set_fibers(slot, young, m);
  return m;
}

[[gnu::always_inline]] inline Vec3 corner_gradient(int corner, Vec3 slope) {
  const Int3 side = corner_sign(corner);
  return {Real(side.x) * slope.x, Real(side.y) * slope.y, Real(side.z) * slope.z};
}

/// Adds a cell at a corner. `history`: null for elastic cells.
///   f = −V P g − V F H g − V κ/8 q         Hessian of H : ½ (Fᵀ F − 1): (g · H g) 1, its positive part
template <class Law>
[[gnu::always_inline]] inline void add_cell_of(NodeSystem& s, const CellGradient& u, Vec3 g,
                                               const CellModuli& m) {
  Law::add(s, u, g, m);
  s.f -= u.hourglass_displacement * m.hourglass;
  add_isotropic(s, m.hourglass * Real(0.5));
}
[[gnu::always_inline]] inline void add_history(NodeSystem& s, const CellGradient& u, Vec3 g,
                                               const CellHistory& h) {
  const Vec3 hg = h.times(g);
  s.f -= hg + u.x * hg.x + u.y * hg.y + u.z * hg.z;
  add_isotropic(s, positive(dot(g, hg)));
}

template <class Law, bool kViscous>
void gather_cells_of(const NodeArrays& n, const CellLawView& view, const NodeBlock& block,
                     const Real* const (&young)[kCellCorners], int slot, int begin,
                     SystemBuffer& __restrict out) {
  const CellLawView laws = view;
  int lowest[kCellCorners];
  for (int at = 0; at < kCellCorners; at++) lowest[at] = corner_slot(block, slot, at, 0);
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++) {
    const int a = slot + i;
    NodeSystem s;
    Vec3 u[kBlockNodes];
    TURGOR_UNROLL
    for (int b = 0; b < kBlockNodes; b++) u[b] = n.u(a + block.offset[b]) - n.u(a);
    TURGOR_UNROLL
    for (int at = 0; at < kCellCorners; at++) {
      Vec3 d[kCellCorners];
      TURGOR_UNROLL
      for (int c = 0; c < kCellCorners; c++) d[c] = u[block_index(cell_corner(c) - cell_corner(at))];
      const CellGradient gradient = cell_gradient(d, at, laws.slope);
      const Vec3 g = corner_gradient(at, laws.slope);
      add_cell_of<Law>(s, gradient, g, moduli_of<Law>(laws, lowest[at] + i, young[at][i]));
      if constexpr (kViscous) add_history(s, gradient, g, laws.history_of(lowest[at] + i));
    }
    out.set(begin + i, s);
  }
}

/// Displacement gradient of the cell whose lowest node is slot a.
[[gnu::always_inline]] inline CornerSums sums_of_cell(const NodeArrays& n, const int (&corner)[kCellCorners],
                                                      int a, Vec3 (&d)[kCellCorners]) {
#pragma GCC unroll 8
  for (int c = 0; c < kCellCorners; c++) d[c] = n.u(a + corner[c]) - n.u(a);
  return corner_sums(d);
}

template <class Law, bool kViscous, int kWidth>
void corner_forces_of(const NodeArrays& nodes, const CellLawView& view, const NodeBlock& block,
                      const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& __restrict out) {
  const CellLawView laws = view;
  const NodeArrays n = nodes;
  int corner[kCellCorners];
  for (int c = 0; c < kCellCorners; c++) corner[c] = corner_slot(block, 0, 0, c);
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const int a = slot + i;
    Vec3 d[kCellCorners];
    const CornerSums sums = sums_of_cell(n, corner, a, d);
    const Vec3 ux = sums.x * laws.slope.x, uy = sums.y * laws.slope.y, uz = sums.z * laws.slope.z;
    const CellModuli m = moduli_of<Law>(laws, a, young[i]);
    CellPiola p = Law::piola(ux, uy, uz, m);
    if constexpr (kViscous) {  // P + F H
      const CellHistory h = laws.history_of(a);
      const Vec3 fx = ux + Vec3{1, 0, 0}, fy = uy + Vec3{0, 1, 0}, fz = uz + Vec3{0, 0, 1};
      p.x += fx * h.xx + fy * h.xy + fz * h.xz;
      p.y += fx * h.xy + fy * h.yy + fz * h.yz;
      p.z += fx * h.xz + fy * h.yz + fz * h.zz;
    }
    const CellStress stress{p.x * -laws.slope.x, p.y * -laws.slope.y, p.z * -laws.slope.z, sums, m.hourglass};
#pragma GCC unroll 8
    for (int c = 0; c < kCellCorners; c++) {
      const Vec3 f = corner_force(stress, d[c], c);
      out.x[c][i] = f.x, out.y[c][i] = f.y, out.z[c][i] = f.z;
    }
  }
}

/// √(⅔ e : e) of the displacement gradient's columns.
[[gnu::always_inline]] inline Real equivalent_strain(Vec3 ux, Vec3 uy, Vec3 uz) {
  const Real xx = ux.x + Real(0.5) * dot(ux, ux), yy = uy.y + Real(0.5) * dot(uy, uy),
             zz = uz.z + Real(0.5) * dot(uz, uz), mean = (xx + yy + zz) / 3;
  const Real xy = ux.y + uy.x + dot(ux, uy), xz = ux.z + uz.x + dot(ux, uz), yz = uy.z + uz.y + dot(uy, uz);
  const Real a = xx - mean, b = yy - mean, c = zz - mean;
  return square_root(Real(2) / 3 * (a * a + b * b + c * c + Real(0.5) * (xy * xy + xz * xz + yz * yz)));
}

/// S = F⁻¹ P = (cof F)ᵀ P/J
template <class Law>
void stresses_of(const NodeArrays& nodes, const CellLawView& view, const NodeBlock& block,
                 const Real (&young)[kGroup], int slot, LawStresses& __restrict out) {
  const CellLawView laws = view;
  const NodeArrays n = nodes;
  int corner[kCellCorners];
  for (int c = 0; c < kCellCorners; c++) corner[c] = corner_slot(block, 0, 0, c);
  TURGOR_LANES
  for (int i = 0; i < kGroup; i++) {
    const int a = slot + i;
    Vec3 d[kCellCorners];
    const CornerSums sums = sums_of_cell(n, corner, a, d);
    const Vec3 ux = sums.x * laws.slope.x, uy = sums.y * laws.slope.y, uz = sums.z * laws.slope.z;
    const CellModuli m = moduli_of<Law>(laws, a, young[i]);
    const CellPiola p = Law::piola(ux, uy, uz, m);
    const CellCofactor k = cell_cofactor(ux, uy, uz);
    const Real j = 1 + k.growth, inverse = 1 / (j > kLeastGrowth ? j : kLeastGrowth);
    const Vec3 kx = k.x + Vec3{1, 0, 0}, ky = k.y + Vec3{0, 1, 0}, kz = k.z + Vec3{0, 0, 1};
    out.of[0][i] = dot(kx, p.x) * inverse, out.of[1][i] = dot(ky, p.y) * inverse;
    out.of[2][i] = dot(kz, p.z) * inverse, out.of[3][i] = dot(kx, p.y) * inverse;
    out.of[4][i] = dot(kx, p.z) * inverse, out.of[5][i] = dot(ky, p.z) * inverse;
    out.strain[i] = equivalent_strain(ux, uy, uz);
  }
}

}  // namespace

CellLawView cell_law_view(const Model& model, const State& state) {
  const CellLaws& laws = model.anatomy.cell_laws;
  const TissueParams& tissue = model.params.tissue;
  const Vec3d h(model.anatomy.lattice.spacing);
  CellLawView view{.energy = tissue.energy,
                   .slope = solid_law(model.anatomy.lattice.spacing, tissue.poisson).slope,
                   .hourglass = Real(hourglass_over_shear(tissue.energy) / dot(h, h) / 8),
                   .shear = laws.shear.empty() ? nullptr : laws.shear.data(),
                   .bulk = laws.bulk.data(),
                   .stiffening = laws.stiffening.data(),
                   .fiber = laws.fiber.empty() ? nullptr : laws.fiber.data(),
                   .fiber_stiffening = laws.fiber_stiffening.data(),
                   .fiber_x = laws.fiber_x.data(),
                   .fiber_y = laws.fiber_y.data(),
                   .fiber_z = laws.fiber_z.data(),
                   .instant = 1,
                   .history = {}};
  const Viscosity& viscosity = state.viscosity;
  if (!viscosity.in_step) return view;
  TURGOR_CHECK(!viscosity.history.empty() && view.has_laws(),
               "a viscous body has laws by cell and a history");
  view.instant = viscosity.instant;
  const SymmetricField& sum = viscosity.history[0];
  const aligned_vector<Real>* entries[] = {&sum.xx, &sum.yy, &sum.zz, &sum.xy, &sum.xz, &sum.yz};
  for (std::size_t e = 0; e < 6; e++) view.history[e] = entries[e]->data();
  return view;
}

void gather_law_cells(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                      const Real* const (&young)[kCellCorners], int slot, int begin, SystemBuffer& out) {
  with_law(laws, [&]<class Law>(Law) {
    if (laws.history[0] != nullptr)
      gather_cells_of<Law, true>(n, laws, block, young, slot, begin, out);
    else
      gather_cells_of<Law, false>(n, laws, block, young, slot, begin, out);
  });
}

template <int kWidth>
void law_corner_forces(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                       const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& out) {
  with_law(laws, [&]<class Law>(Law) {
    if (laws.history[0] != nullptr)
      corner_forces_of<Law, true, kWidth>(n, laws, block, young, slot, out);
    else
      corner_forces_of<Law, false, kWidth>(n, laws, block, young, slot, out);
  });
}
template void law_corner_forces(const NodeArrays&, const CellLawView&, const NodeBlock&,
                                const Real (&)[kGroup], int, LawCornerForces<kGroup>&);
template void law_corner_forces(const NodeArrays&, const CellLawView&, const NodeBlock&,
                                const Real (&)[2 * kGroup], int, LawCornerForces<2 * kGroup>&);

void law_stresses(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                  const Real (&young)[kGroup], int slot, LawStresses& out) {
  with_law(laws, [&]<class Law>(Law) { stresses_of<Law>(n, laws, block, young, slot, out); });
}

void add_viscous_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& laws, int slot,
                          Real young) {
  const Vec3 g = corner_gradient(at, laws.slope);
  with_law(laws, [&]<class Law>(Law) { add_cell_of<Law>(s, u, g, moduli_of<Law>(laws, slot, young)); });
  if (laws.history[0] != nullptr) add_history(s, u, g, laws.history_of(slot));
}

void add_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& laws, int slot,
                  Real young) {
  CellLawView elastic = laws;
  elastic.instant = 1;
  with_law(laws, [&]<class Law>(Law) {
    add_cell_of<Law>(s, u, corner_gradient(at, laws.slope), moduli_of<Law>(elastic, slot, young));
  });
}

}  // namespace turgor::lattice
