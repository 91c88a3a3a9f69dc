#include "turgor/models/lattice/solver/viscosity.hpp"

#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"

namespace turgor::lattice {

namespace {

/// Decay and weight of a pair in a step: a = exp(−h/τ), w = p (1 − a) τ/h.
struct PairStep {
  Real decay, weight;
};
std::array<PairStep, kMostPronyPairs> pair_steps(const Prony& prony, double dt) {
  std::array<PairStep, kMostPronyPairs> steps{};
  for (std::size_t i = 0; i < std::size_t(pair_count(prony)); i++) {
    const double x = dt / prony.pairs[i].time;
    steps[i] = {Real(std::exp(-x)), Real(prony.pairs[i].ratio * -std::expm1(-x) / x)};
  }
  return steps;
}

std::array<aligned_vector<Real>*, 6> entries_of(SymmetricField& field) {
  return {&field.xx, &field.yy, &field.zz, &field.xy, &field.xz, &field.yz};
}

/// Calls visit(slot, young, stresses) for the groups of slots of all layers that have an uncut cell.
template <class Visit>
void for_each_stress(const Exec& exec, const Model& model, State& state, const Visit& visit) {
  const Lattice& l = model.anatomy.lattice;
  const CellLawView laws = cell_law_view(model, state);
  const NodeArrays nodes = node_arrays(model, state);
  parallel_for(exec, std::size_t(l.size.z - 1), [&](std::size_t k) {
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++) {
        const NodeBlock block = node_block(l, parity);
        const int first = row_slot(l, j, int(k)) + parity * l.half;
        for (int begin = 0; begin < half_count(l, parity); begin += kGroup) {
          // moduli of uncut cells
          const int slot = first + begin;
          Real young[kGroup], any = 0;
          for (int i = 0; i < kGroup; i++) {
            young[i] = model.anatomy.cell_young[std::size_t(slot + i)];
            any += young[i];
          }
          if (!(any > 0)) continue;
          if (state.cuts.row_cut[std::size_t(slot / row_stride(l))])
            for (int i = 0; i < kGroup; i++)
              young[i] = cell_modulus(young[i], cut_edges_of_cell(nodes.cut, block, slot + i, 0),
                                      nodes.cut[slot + i])
                             .young;
          // stresses
          LawStresses stresses;
          law_stresses(nodes, laws, block, young, slot, stresses);
          visit(slot, young, stresses);
        }
      }
  });
}

}  // namespace

double instant_factor(const Prony& prony, double dt) {
  double factor = 1;
  for (const PairStep& step : pair_steps(prony, dt)) factor += double(step.weight);
  return factor;
}

void begin_viscous_step(const Exec& exec, const Model& model, State& state, double dt) {
  if (!is_viscous(model)) return;
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  const auto pairs = std::size_t(pair_count(model.params.tissue.prony));
  const std::array<PairStep, kMostPronyPairs> steps = pair_steps(model.params.tissue.prony, dt);
  Viscosity& viscosity = state.viscosity;
  // memory
  if (viscosity.history.size() != pairs) {
    viscosity.history.assign(pairs, {});
    for (SymmetricField& field : viscosity.history)
      for (aligned_vector<Real>* entry : entries_of(field)) entry->assign(model.anatomy.cell_young.size(), 0);
  }
  // decay, and the old stress
  viscosity.in_step = false;
  for_each_stress(exec, model, state, [&](int slot, const Real(&young)[kGroup], const LawStresses& stresses) {
    for (std::size_t e = 0; e < 6; e++) {
      Real sum[kGroup] = {};
      for (std::size_t p = 0; p < pairs; p++) {
        Real* h = entries_of(viscosity.history[p])[e]->data() + slot;
        for (int i = 0; i < kGroup; i++) {
          h[i] = young[i] > 0 ? steps[p].decay * h[i] - steps[p].weight * stresses.of[e][i] : 0;
          sum[i] += h[i];
        }
      }
      Real* first = entries_of(viscosity.history[0])[e]->data() + slot;
      for (int i = 0; i < kGroup; i++) first[i] = sum[i];
    }
  });
  viscosity.instant = Real(instant_factor(model.params.tissue.prony, dt));
  viscosity.in_step = true;
}

void end_viscous_step(const Exec& exec, const Model& model, State& state, double dt) {
  if (!is_viscous(model)) return;
  const auto pairs = std::size_t(pair_count(model.params.tissue.prony));
  const std::array<PairStep, kMostPronyPairs> steps = pair_steps(model.params.tissue.prony, dt);
  Viscosity& viscosity = state.viscosity;
  TURGOR_CHECK(viscosity.in_step && viscosity.history.size() == pairs, "a viscous step has begun");
  viscosity.in_step = false;
  for_each_stress(exec, model, state, [&](int slot, const Real(&)[kGroup], const LawStresses& stresses) {
    for (std::size_t e = 0; e < 6; e++) {
      Real* first = entries_of(viscosity.history[0])[e]->data() + slot;
      for (std::size_t p = 1; p < pairs; p++) {
        Real* h = entries_of(viscosity.history[p])[e]->data() + slot;
        for (int i = 0; i < kGroup; i++) {
          first[i] -= h[i];
          h[i] += steps[p].weight * stresses.of[e][i];
        }
      }
      for (int i = 0; i < kGroup; i++) first[i] += steps[0].weight * stresses.of[e][i];
    }
  });
}

}  // namespace turgor::lattice
