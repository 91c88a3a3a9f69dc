// Viscous solid cells: a Prony series of up to three pairs on the second Piola-Kirchhoff stress S, so that no
// rotation enters (quasi-linear viscoelasticity). Moduli are static ones. For pair i, step h, a = exp(−h/τ),
// w = p (1 − a) τ/h:
//
//     S_total = S(F) + Σ Hᵢ,   Hᵢ ← aᵢ Hᵢ + wᵢ (S_new − S_old)
//
// Within a step this is the elastic energy with its moduli times 1 + Σ wᵢ, plus the linear energy Σ (aᵢ Hᵢ −
// wᵢ S_old) : ½ (Fᵀ F − 1). Steps stay variational. [Simo 1987; Taylor, Pister, Goudreau 1970]
//
// The history is six numbers a pair and cell. Cut cells have none: they answer with their static moduli at
// once.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// True if cells relax.
inline bool is_viscous(const Model& model) { return pair_count(model.params.tissue.prony) > 0; }

/// Factor of the moduli within a step, 1 + Σ wᵢ; 1 without pairs.
double instant_factor(const Prony& prony, double dt);

/// Before the nodes move: Hᵢ ← aᵢ Hᵢ − wᵢ S_old, and the first entry of the history holds the sum over the
/// pairs.
void begin_viscous_step(const Exec& exec, const Model& model, State& state, double dt);
/// After they moved: Hᵢ ← Hᵢ + wᵢ S_new.
void end_viscous_step(const Exec& exec, const Model& model, State& state, double dt);

}  // namespace turgor::lattice
