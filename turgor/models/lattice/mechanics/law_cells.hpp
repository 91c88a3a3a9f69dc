// Loops over cells that have laws of their own (solid_laws.hpp): moduli by cell, exponential or Ogden tissue,
// and viscous tissue. Uniform neo-Hookean cells, the default, are in cells.hpp.
#pragma once

#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

/// Symmetric tensor: the part of a viscous cell's stress that is constant within a step, times its volume
/// [J].
struct CellHistory {
  Real xx, yy, zz, xy, xz, yz;

  TURGOR_HD Vec3 times(Vec3 g) const {
    return {xx * g.x + xy * g.y + xz * g.z, xy * g.x + yy * g.y + yz * g.z, xz * g.x + yz * g.y + zz * g.z};
  }
};

/// Laws of all cells, by slot of their lowest node, as plain pointers.
struct CellLawView {
  SolidEnergy energy;                     // of all cells, if `energies` is null
  const std::uint8_t* energies;           // SolidEnergy by cell; null: all cells have `energy`
  Vec3 slope;                             // SolidLaw::slope [1/m]
  Real hourglass;                         // hourglass modulus over shear modulus, over 8 [1/m²]
  Real hourglasses[kSolidEnergyCount];    // the same by energy
  const Real *shear, *bulk, *stiffening;  // CellLaws; null: all cells follow SolidLaw
  const Real *fiber, *fiber_stiffening, *fiber_x, *fiber_y, *fiber_z;  // null: no fibers
  Real instant;            // factor of the moduli within a step, 1 + Σ pᵢ γᵢ (viscosity.hpp)
  const Real* instants;    // the same by cell, where layers have pairs of their own; null = `instant`
  const Real* history[6];  // xx, yy, zz, xy, xz, yz; null = elastic [J]

  bool has_laws() const { return shear != nullptr; }
  SolidEnergy energy_at(int slot) const { return energies != nullptr ? SolidEnergy(energies[slot]) : energy; }
  /// View in which all cells have this energy.
  CellLawView with_energy(SolidEnergy of) const {
    CellLawView view = *this;
    view.energy = of, view.energies = nullptr, view.hourglass = hourglasses[std::size_t(of)];
    return view;
  }
  /// `factor`: instant or instants[slot].
  [[gnu::always_inline]] TURGOR_HD CellModuli moduli(int slot, Real young, Real factor) const {
    const Real static_shear = young * shear[slot];
    return {static_shear * factor, young * bulk[slot] * factor, stiffening[slot], static_shear * hourglass};
  }
  [[gnu::always_inline]] TURGOR_HD void set_fibers(int slot, Real young, Real factor, CellModuli& m) const {
    m.fiber = young * fiber[slot] * factor, m.fiber_stiffening = fiber_stiffening[slot];
    m.direction = {fiber_x[slot], fiber_y[slot], fiber_z[slot]};
  }
  /// Moduli, with those of fibers if there are any.
  CellModuli all_moduli(int slot, Real young) const {
    const Real factor = instants != nullptr ? instants[slot] : instant;
    CellModuli m = moduli(slot, young, factor);
    if (fiber != nullptr) set_fibers(slot, young, factor, m);
    m.hourglass = young * shear[slot] * hourglasses[std::size_t(energy_at(slot))];
    return m;
  }
  TURGOR_HD CellHistory history_of(int slot) const {
    return {history[0][slot], history[1][slot], history[2][slot],
            history[3][slot], history[4][slot], history[5][slot]};
  }
};
CellLawView cell_law_view(const Model& model, const State& state);

/// Cells of several laws beside each other are computed once by each law, with the moduli of the others at 0.
///
/// Systems of the cells around the nodes of [slot, slot + kSpareSlots), from `begin` of the buffer on.
/// young[n]: moduli of the cells whose corner n these nodes are, 0 where cut.
void gather_law_cells(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                      const Real* const (&young)[kCellCorners], int slot, int begin, SystemBuffer& out);

/// Forces on the corners of the cells with lowest nodes [slot, slot + kWidth) [N]. kWidth: 8 or 16.
template <int kWidth>
struct LawCornerForces {
  Real x[kCellCorners][kWidth], y[kCellCorners][kWidth], z[kCellCorners][kWidth];
};
template <int kWidth>
void law_corner_forces(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                       const Real (&young)[kWidth], int slot, LawCornerForces<kWidth>& out);

/// Second Piola-Kirchhoff stress times V of the cells with lowest nodes [slot, slot + kWidth), without
/// history [J], and their equivalent strain √(⅔ e : e) with e the deviator of Green's strain [1]. kWidth: 8
/// or 16.
template <int kWidth>
struct LawStresses {
  Real of[6][kWidth];  // xx, yy, zz, xy, xz, yz
  Real strain[kWidth];
};
template <int kWidth>
void law_stresses(const NodeArrays& n, const CellLawView& laws, const NodeBlock& block,
                  const Real (&young)[kWidth], int slot, LawStresses<kWidth>& out);

/// Adds a whole cell at its corner `at`, with its history; `slot`: its lowest node.
void add_viscous_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& laws, int slot,
                          Real young);
/// Adds an element of a cut cell at its corner `at`; `slot`: lowest node of its cell. Cut cells are elastic.
void add_law_cell(NodeSystem& s, const CellGradient& u, int at, const CellLawView& laws, int slot,
                  Real young);

}  // namespace turgor::lattice
