// Viscous solid cells: a Prony series of up to three pairs on the second Piola-Kirchhoff stress S, so that no
// rotation enters (quasi-linear viscoelasticity). Moduli are static ones. For pair i, step h, a = exp(−h/τ),
// w = p (1 − a) τ/h:
//
//     S_total = S(F) + Σ Hᵢ,   Hᵢ ← aᵢ Hᵢ + wᵢ (S_new − S_old)
//
// Within a step this is the elastic energy with its moduli times 1 + Σ wᵢ, plus the linear energy Σ (aᵢ Hᵢ −
// wᵢ S_old) : ½ (Fᵀ F − 1). Steps stay variational. [Simo 1987; Taylor, Pister, Goudreau 1970]
//
// Permanent set: a stress Q that is subtracted from S and never returns. With ε the equivalent strain of a
// cell and ε₀ the strain at which setting begins:
//   Q ← Q + (1 − exp(−h/τ)) (T − Q)      T = share (1 − ε₀/ε) S_new      if ε > ε₀ and (T − Q) : T > 0
// The last field of the history holds −Q. A bar under a constant stress σ > E ε₀ sets by
//   E ε_set = share (σ − E ε₀)/(1 − share) (1 − exp(−(1 − share) t/τ))
//
// The history is six numbers a pair and cell, and six for the set. Cut cells have none: they answer with
// their static moduli at once.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// True if cells have a history.
inline bool is_viscous(const Model& model) {
  return most_pairs(model.params.tissue) > 0 || has_set(model.params.tissue.set);
}

/// Factors of the moduli within a step, 1 + Σ wᵢ, by entry of CellLaws::relaxation; the first one is that of
/// the body. 1 without pairs.
std::vector<double> instant_factors(const Model& model, double dt);

/// Before the nodes move: Hᵢ ← aᵢ Hᵢ − wᵢ S_old, and the first entry of the history holds the sum over the
/// pairs.
void begin_viscous_step(const Exec& exec, const Model& model, State& state, double dt);
/// After they moved: Hᵢ ← Hᵢ + wᵢ S_new, and the set grows. `finite` = false: the step was undone. The set
/// stays, and the history is restored to rounding; pairs that relax within a step have none.
void end_viscous_step(const Exec& exec, const Model& model, State& state, double dt, bool finite = true);

/// Largest equivalent strain that is set, |dev Q|/2µ: what a cell keeps without load [1].
double largest_set(const Exec& exec, const Model& model, const State& state);

}  // namespace turgor::lattice
