#include "turgor/models/lattice/mechanics/law_cells.hpp"

#include <bit>
#include <optional>
#include <type_traits>

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

/// Calls f(law, has a history) with both as types, so that loops over cells know them.
template <class F>
void with_relaxing_law(const CellLawView& laws, const F& f) {
  with_law(laws, [&]<class Law>(Law law) {
    if (laws.history[0] == nullptr)
      f(law, std::false_type{});
    else
      f(law, std::true_type{});
  });
}

/// Factors of the moduli of the cells from `slot` on. They are read before the loop over cells, which then is
/// the same whether layers relax alike or not.
template <int kWidth>
[[gnu::always_inline]] inline void read_factors(const CellLawView& laws, int slot, Real (&factor)[kWidth]) {
  for (int i = 0; i < kWidth; i++)
    factor[i] = laws.instants != nullptr ? laws.instants[slot + i] : laws.instant;
}

template <class Law>
[[gnu::always_inline]] inline CellModuli moduli_of(const CellLawView& laws, int slot, Real young,
                                                   Real factor) {
  CellModuli m = laws.moduli(slot, young, factor);
  if constexpr (Law::kHasFibers) laws.set_fibers(slot, young, factor, m);
  return m;
}

[[gnu::always_inline]] inline Vec3 corner_gradient(int corner, Vec3 slope) {
  const Int3 side = corner_sign(corner);
  return {Real(side.x) * slope.x, Real(side.y) * slope.y, Real(side.z) * slope.z};
}

/// Adds a cell at a corner, and its history. Both return the factor of the Hessian's multiple of the
/// identity.
///   f = −V P g − V F H g − V κ/8 q         Hessian of H : ½ (Fᵀ F − 1): (g · H g) 1, its positive part
template <class Law>
[[gnu::always_inline]] inline Real add_cell_of(NodeSystem& s, const CellGradient& u, Vec3 g,
                                               const CellModuli& m) {
  const Real isotropic = Law::add(s, u, g, m);
  s.f -= u.hourglass_displacement * m.hourglass;
  return isotropic + m.hourglass * Real(0.5);
}
[[gnu::always_inline]] inline Real add_history(NodeSystem& s, const CellGradient& u, Vec3 g,
                                               const CellHistory& h) {
  const Vec3 hg = h.times(g);
  s.f -= hg + u.x * hg.x + u.y * hg.y + u.z * hg.z;
  return at_least(dot(g, hg), 0);
}

template <class Law, bool kHasHistory>
void gather_cells_of(const NodeArrays& n, const CellLawView& view, const NodeBlock& block,
                     const Real* const (&young)[kCellCorners], int slot, int begin,
                     SystemBuffer& __restrict out) {
  const CellLawView laws = view;
  int lowest[kCellCorners];
  Real factor[kCellCorners][kSpareSlots];
  for (int at = 0; at < kCellCorners; at++) {
    lowest[at] = corner_slot(block, slot, at, 0);
    read_factors(laws, lowest[at], factor[at]);
  }
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++) {
    const int a = slot + i;
    NodeSystem s;
    Real isotropic = 0;
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
      isotropic +=
          add_cell_of<Law>(s, gradient, g, moduli_of<Law>(laws, lowest[at] + i, young[at][i], factor[at][i]));
      if constexpr (kHasHistory) isotropic += add_history(s, gradient, g, laws.history_of(lowest[at] + i));
    }
    add_isotropic(s, isotropic);
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

template <class Law, bool kHasHistory, int kWidth>
void corner_forces_of(const NodeArrays& nodes, const CellLawView& view, const NodeBlock& block,
                      const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& __restrict out) {
  const CellLawView laws = view;
  const NodeArrays n = nodes;
  int corner[kCellCorners];
  for (int c = 0; c < kCellCorners; c++) corner[c] = corner_slot(block, 0, 0, c);
  Real factor[kWidth];
  read_factors(laws, slot, factor);
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const int a = slot + i;
    Vec3 d[kCellCorners];
    const CornerSums sums = sums_of_cell(n, corner, a, d);
    const Vec3 ux = sums.x * laws.slope.x, uy = sums.y * laws.slope.y, uz = sums.z * laws.slope.z;
    const CellModuli m = moduli_of<Law>(laws, a, young[i], factor[i]);
    CellPiola p = Law::piola(ux, uy, uz, m);
    if constexpr (kHasHistory) {  // P + F H
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
template <class Law, int kWidth>
void stresses_of(const NodeArrays& nodes, const CellLawView& view, const NodeBlock& block,
                 const Real (&young)[kWidth], int slot, LawStresses<kWidth>& __restrict out) {
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
    const CellModuli m = moduli_of<Law>(laws, a, young[i], laws.instant);
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

/// Cells of one law around the nodes of a group.
void gather_one_law(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                    const Real* const (&young)[kCellCorners], int slot, int begin, SystemBuffer& out) {
  with_relaxing_law(laws, [&]<class Law, bool kHasHistory>(Law, std::bool_constant<kHasHistory>) {
    gather_cells_of<Law, kHasHistory>(n, laws, block, young, slot, begin, out);
  });
}
template <int kWidth>
void one_law_forces(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                    const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& out) {
  with_relaxing_law(laws, [&]<class Law, bool kHasHistory>(Law, std::bool_constant<kHasHistory>) {
    corner_forces_of<Law, kHasHistory, kWidth>(n, laws, block, young, slot, out);
  });
}

/// Bits of the energies of the cells from `slot` on that have a modulus.
template <int kWidth>
unsigned energies_among(const CellLawView& laws, const Real* young, int slot) {
  unsigned found = 0;
  for (int i = 0; i < kWidth; i++) found |= young[i] > 0 ? 1u << laws.energies[slot + i] : 0;
  return found;
}
/// Moduli of the cells of one energy, 0 for others.
template <int kWidth>
void mask_young(const CellLawView& laws, SolidEnergy energy, const Real* young, int slot, Real* out) {
  for (int i = 0; i < kWidth; i++) out[i] = laws.energies[slot + i] == std::uint8_t(energy) ? young[i] : 0;
}
/// Calls visit(energy, view of that energy, is the first) for each bit. The history is in the first view
/// only.
template <class Visit>
void for_each_energy(const CellLawView& laws, unsigned found, const Visit& visit) {
  bool is_first = true;
  for (int e = 0; e < kSolidEnergyCount; e++) {
    if (!(found >> e & 1)) continue;
    CellLawView view = laws.with_energy(SolidEnergy(e));
    if (!is_first) view.history[0] = nullptr;
    visit(SolidEnergy(e), view, is_first);
    is_first = false;
  }
}
/// Energy of the only bit, or of the body's without bits; empty for several.
std::optional<SolidEnergy> only_energy(const CellLawView& laws, unsigned found) {
  if (found == 0) return laws.energy;
  if (!std::has_single_bit(found)) return std::nullopt;
  return SolidEnergy(std::countr_zero(found));
}

void gather_mixed_laws(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                       const Real* const (&young)[kCellCorners], const int (&lowest)[kCellCorners],
                       unsigned found, int slot, int begin, SystemBuffer& out) {
  for_each_energy(laws, found, [&](SolidEnergy energy, const CellLawView& view, bool is_first) {
    // moduli of this law
    Real masked[kCellCorners][kSpareSlots];
    const Real* of[kCellCorners];
    for (int at = 0; at < kCellCorners; at++) {
      mask_young<kSpareSlots>(laws, energy, young[at], lowest[at], masked[at]);
      of[at] = masked[at];
    }
    // sum of the laws
    if (is_first) return gather_one_law(n, view, block, of, slot, begin, out);
    SystemBuffer more;
    gather_one_law(n, view, block, of, slot, 0, more);
    for (int i = 0; i < kSpareSlots; i++) {
      NodeSystem s = out.get(begin + i);
      const NodeSystem other = more.get(i);
      s.f += other.f;
      s.xx += other.xx, s.yy += other.yy, s.zz += other.zz;
      s.xy += other.xy, s.xz += other.xz, s.yz += other.yz;
      out.set(begin + i, s);
    }
  });
}

template <int kWidth>
void mixed_law_forces(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                      const Real (&young)[kWidth], unsigned found, int slot, LawCornerForces<kWidth>& out) {
  for_each_energy(laws, found, [&](SolidEnergy energy, const CellLawView& view, bool is_first) {
    Real masked[kWidth];
    mask_young<kWidth>(laws, energy, young, slot, masked);
    if (is_first) return one_law_forces(n, view, block, masked, slot, out);
    LawCornerForces<kWidth> more;
    one_law_forces(n, view, block, masked, slot, more);
    for (int c = 0; c < kCellCorners; c++)
      for (int i = 0; i < kWidth; i++)
        out.x[c][i] += more.x[c][i], out.y[c][i] += more.y[c][i], out.z[c][i] += more.z[c][i];
  });
}

}  // namespace

CellLawView cell_law_view(const Model& model, const State& state) {
  const CellLaws& laws = model.anatomy.cell_laws;
  const TissueParams& tissue = model.params.tissue;
  const Vec3d h(model.anatomy.lattice.spacing);
  CellLawView view{.energy = tissue.energy,
                   .energies = laws.energy.empty() ? nullptr : laws.energy.data(),
                   .slope = solid_law(model.anatomy.lattice.spacing, tissue.poisson).slope,
                   .hourglass = 0,
                   .hourglasses = {},
                   .shear = laws.shear.empty() ? nullptr : laws.shear.data(),
                   .bulk = laws.bulk.data(),
                   .stiffening = laws.stiffening.data(),
                   .fiber = laws.fiber.empty() ? nullptr : laws.fiber.data(),
                   .fiber_stiffening = laws.fiber_stiffening.data(),
                   .fiber_x = laws.fiber_x.data(),
                   .fiber_y = laws.fiber_y.data(),
                   .fiber_z = laws.fiber_z.data(),
                   .instant = 1,
                   .instants = nullptr,
                   .history = {}};
  for (int e = 0; e < kSolidEnergyCount; e++)
    view.hourglasses[e] = Real(hourglass_over_shear(SolidEnergy(e)) / dot(h, h) / 8);
  view.hourglass = view.hourglasses[std::size_t(tissue.energy)];
  const Viscosity& viscosity = state.viscosity;
  if (!viscosity.in_step) return view;
  TURGOR_CHECK(!viscosity.history.empty() && view.has_laws(),
               "a viscous body has laws by cell and a history");
  view.instant = viscosity.instant;
  if (!viscosity.instants.empty()) view.instants = viscosity.instants.data();
  const SymmetricField& sum = viscosity.history[0];
  const aligned_vector<Real>* entries[] = {&sum.xx, &sum.yy, &sum.zz, &sum.xy, &sum.xz, &sum.yz};
  for (std::size_t e = 0; e < 6; e++) view.history[e] = entries[e]->data();
  return view;
}

void gather_law_cells(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                      const Real* const (&young)[kCellCorners], int slot, int begin, SystemBuffer& out) {
  if (laws.energies == nullptr) return gather_one_law(n, laws, block, young, slot, begin, out);
  int lowest[kCellCorners];
  unsigned found = 0;
  for (int at = 0; at < kCellCorners; at++) {
    lowest[at] = corner_slot(block, slot, at, 0);
    found |= energies_among<kSpareSlots>(laws, young[at], lowest[at]);
  }
  if (const std::optional<SolidEnergy> one = only_energy(laws, found))
    gather_one_law(n, laws.with_energy(*one), block, young, slot, begin, out);
  else
    gather_mixed_laws(n, laws, block, young, lowest, found, slot, begin, out);
}

template <int kWidth>
void law_corner_forces(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                       const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& out) {
  if (laws.energies == nullptr) return one_law_forces(n, laws, block, young, slot, out);
  const unsigned found = energies_among<kWidth>(laws, young, slot);
  if (const std::optional<SolidEnergy> one = only_energy(laws, found))
    one_law_forces(n, laws.with_energy(*one), block, young, slot, out);
  else
    mixed_law_forces(n, laws, block, young, found, slot, out);
}
template void law_corner_forces(const NodeArrays&, const CellLawView&, const NodeBlock&,
                                const Real (&)[kGroup], int, LawCornerForces<kGroup>&);
template void law_corner_forces(const NodeArrays&, const CellLawView&, const NodeBlock&,
                                const Real (&)[2 * kGroup], int, LawCornerForces<2 * kGroup>&);

template <int kWidth>
void law_stresses(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                  const Real (&young)[kWidth], int slot, LawStresses<kWidth>& out) {
  const auto of_law = [&](const CellLawView& view, LawStresses<kWidth>& to) {
    with_law(view, [&]<class Law>(Law) { stresses_of<Law, kWidth>(n, view, block, young, slot, to); });
  };
  if (laws.energies == nullptr) return of_law(laws, out);
  const unsigned found = energies_among<kWidth>(laws, young, slot);
  if (const std::optional<SolidEnergy> one = only_energy(laws, found))
    return of_law(laws.with_energy(*one), out);
  // each cell takes the stress of its law
  for_each_energy(laws, found, [&](SolidEnergy energy, const CellLawView& view, bool is_first) {
    if (is_first) return of_law(view, out);
    LawStresses<kWidth> other;
    of_law(view, other);
    for (auto e = 0; e < 6; e++)
      for (int i = 0; i < kWidth; i++)
        if (laws.energies[slot + i] == std::uint8_t(energy)) out.of[e][i] = other.of[e][i];
  });
}
template void law_stresses(const NodeArrays&, const CellLawView&, const NodeBlock&, const Real (&)[kGroup],
                           int, LawStresses<kGroup>&);
template void law_stresses(const NodeArrays&, const CellLawView&, const NodeBlock&,
                           const Real (&)[2 * kGroup], int, LawStresses<2 * kGroup>&);

void add_viscous_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& all, int slot,
                          Real young) {
  const CellLawView laws = all.energies == nullptr ? all : all.with_energy(all.energy_at(slot));
  const Vec3 g = corner_gradient(at, laws.slope);
  const Real factor = laws.instants != nullptr ? laws.instants[slot] : laws.instant;
  with_law(laws, [&]<class Law>(Law) {
    add_isotropic(s, add_cell_of<Law>(s, u, g, moduli_of<Law>(laws, slot, young, factor)));
  });
  if (laws.history[0] != nullptr) add_isotropic(s, add_history(s, u, g, laws.history_of(slot)));
}

void add_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& laws, int slot,
                  Real young) {
  const CellLawView elastic = laws.with_energy(laws.energy_at(slot));
  with_law(elastic, [&]<class Law>(Law) {
    add_isotropic(s, add_cell_of<Law>(s, u, corner_gradient(at, elastic.slope),
                                      moduli_of<Law>(elastic, slot, young, 1)));
  });
}

}  // namespace turgor::lattice
