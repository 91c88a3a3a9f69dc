// Problems of FEBio's test suite (github.com/febiosoftware/TestSuite, Verify4) that laws of this project can
// state, beside the results stored there (code/linuxGoldStandards.py): the norm of all free displacements.
#pragma once

#include "app/measured_table.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor {

inline MeasuredRow febio_row(const std::string& name, double stored, double found) {
  return band_row("FEBio " + name + ": norm of displacements", "FEBio test suite, stored result", "1", stored,
                  0.01 * stored, found);
}

/// Moduli of the neo-Hookean law of lattice cells for Young's modulus 1. FEBio's has µ/2 (I − 3) − µ ln J +
/// λ/2 (ln J)²; both are the same at small strains.
inline lattice::LawModuli febio_neo_hookean(double poisson) {
  const auto [shear, bulk] = lattice::law_ratios(lattice::SolidEnergy::kNeoHookean, poisson);
  return {shear, bulk, 0};
}

/// Problems whose deformation is uniform.
void add_uniform_febio(MeasuredResult& result);

}  // namespace turgor
