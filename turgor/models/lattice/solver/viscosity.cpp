#include "turgor/models/lattice/solver/viscosity.hpp"

#include <algorithm>
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
/// The last field, the set, has no decay and no weight.
using FieldSteps = std::array<PairStep, kMostPronyPairs + 1>;
FieldSteps pair_steps(const Prony& prony, double dt) {
  FieldSteps steps;
  steps.fill({1, 0});
  for (std::size_t i = 0; i < std::size_t(pair_count(prony)); i++) {
    const double x = dt / prony.pairs[i].time;
    steps[i] = {Real(std::exp(-x)), Real(prony.pairs[i].ratio * -std::expm1(-x) / x)};
  }
  return steps;
}

/// Fields of the history: pairs, then the set.
std::size_t field_count(const TissueParams& tissue) {
  return std::size_t(most_pairs(tissue)) + (has_set(tissue.set) ? 1 : 0);
}

constexpr int kWidest = 2 * kGroup;  // cells that are computed at once
/// Steps of cells beside each other, field by field.
struct GroupSteps {
  Real decay[kMostPronyPairs + 1][kWidest], weight[kMostPronyPairs + 1][kWidest];

  void set(int lane, const FieldSteps& steps) {
    for (std::size_t p = 0; p <= kMostPronyPairs; p++)
      decay[p][lane] = steps[p].decay, weight[p][lane] = steps[p].weight;
  }
};
/// Steps of the pairs of all cells; entries as in CellLaws::relaxation.
struct AllSteps {
  std::vector<FieldSteps> of;
  const std::uint8_t* relaxation;  // by slot; null: all cells have of[0]
  GroupSteps of_body;              // of[0] in all lanes

  AllSteps(const Model& model, double dt)
      : of{pair_steps(model.params.tissue.prony, dt)},
        relaxation(model.anatomy.cell_laws.relaxation.empty() ? nullptr
                                                              : model.anatomy.cell_laws.relaxation.data()) {
    for (int i = 0; i < kWidest; i++) of_body.set(i, of[0]);
    if (!relaxation) return;
    for (const TissueLayer& layer : model.params.tissue.layers)
      of.push_back(pair_steps(layer.prony.value_or(model.params.tissue.prony), dt));
  }
  /// Steps of `width` cells from a slot on. `own`: memory for them where layers relax differently.
  const GroupSteps& group(int slot, int width, GroupSteps& own) const {
    if (!relaxation) return of_body;
    for (int i = 0; i < width; i++) own.set(i, of[relaxation[slot + i]]);
    return own;
  }
};

double instant_of(const FieldSteps& steps) {
  double factor = 1;
  for (const PairStep& step : steps) factor += double(step.weight);
  return factor;
}

std::array<aligned_vector<Real>*, 6> entries_of(SymmetricField& field) {
  return {&field.xx, &field.yy, &field.zz, &field.xy, &field.xz, &field.yz};
}
/// Entries of all fields of the history as plain pointers, found once before loops over cells.
struct HistoryEntries {
  std::size_t count;  // of fields
  Real* of[kMostPronyPairs + 1][6];

  explicit HistoryEntries(std::vector<SymmetricField>& history) : count(history.size()), of{} {
    TURGOR_CHECK(count <= kMostPronyPairs + 1, "a history has a field for each pair, and the set");
    for (std::size_t p = 0; p < count; p++)
      for (std::size_t e = 0; e < 6; e++) of[p][e] = entries_of(history[p])[e]->data();
  }
};

/// Moduli of the uncut cells [slot, slot + kWidth), 0 for others. Returns false if all are 0.
template <int kWidth>
bool find_young(const Model& model, const State& state, const NodeArrays& nodes, const NodeBlock& block,
                int slot, Real (&young)[kWidth]) {
  Real any = 0;
  for (int i = 0; i < kWidth; i++) {
    young[i] = model.anatomy.cell_young[std::size_t(slot + i)];
    any += young[i];
  }
  if (!(any > 0)) return false;
  if (state.cuts.row_cut[std::size_t(slot / row_stride(model.anatomy.lattice))])
    for (int i = 0; i < kWidth; i++)
      young[i] =
          cell_modulus(young[i], cut_edges_of_cell(nodes.cut, block, slot + i, 0), nodes.cut[slot + i]).young;
  return true;
}

/// Calls visit(slot, young, stresses) for cells beside each other, sixteen or a group, of which one has a
/// modulus.
template <class Visit>
void for_each_stress(const Exec& exec, const Model& model, State& state, const Visit& visit) {
  const Lattice& l = model.anatomy.lattice;
  const CellLawView laws = cell_law_view(model, state);
  const NodeArrays nodes = node_arrays(model, state);
  const auto visit_cells = [&]<int kWidth>(std::integral_constant<int, kWidth>, const NodeBlock& block,
                                           int slot) {
    Real young[kWidth];
    if (!find_young(model, state, nodes, block, slot, young)) return;
    LawStresses<kWidth> stresses;
    law_stresses(nodes, laws, block, young, slot, stresses);
    visit(slot, young, stresses);
  };
  parallel_for(exec, std::size_t(l.size.z - 1), [&](std::size_t k) {
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++) {
        const NodeBlock block = node_block(l, parity);
        const int first = row_slot(l, j, int(k)) + parity * l.half, count = half_count(l, parity);
        int begin = 0;
        for (; begin + kGroup < count; begin += kWidest)
          visit_cells(std::integral_constant<int, kWidest>(), block, first + begin);
        if (begin < count) visit_cells(std::integral_constant<int, kGroup>(), block, first + begin);
      }
  });
}

/// Hᵢ ← aᵢ Hᵢ − wᵢ S in cells with a modulus, 0 in others. The first field gets the sum.
template <int kFields, int kWidth>
void decay_cells(const HistoryEntries& history, int slot, const GroupSteps& steps,
                 const Real (&young)[kWidth], const LawStresses<kWidth>& stresses) {
  const HistoryEntries h = history;  // local copy, so that stores cannot alias it
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const int at = slot + i;
    TURGOR_UNROLL
    for (int e = 0; e < 6; e++) {
      Real sum = 0;
      TURGOR_UNROLL
      for (int p = 0; p < kFields; p++) {
        const Real all = steps.decay[p][i] * h.of[p][e][at] - steps.weight[p][i] * stresses.of[e][i];
        const Real decayed = young[i] > 0 ? all : 0;
        if (p > 0) h.of[p][e][at] = decayed;
        sum += decayed;
      }
      h.of[0][e][at] = sum;
    }
  }
}
/// Hᵢ ← Hᵢ + wᵢ S; the first field had the sum.
template <int kFields, int kWidth>
void grow_cells(const HistoryEntries& history, int slot, const GroupSteps& steps,
                const LawStresses<kWidth>& stresses) {
  const HistoryEntries h = history;
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const int at = slot + i;
    TURGOR_UNROLL
    for (int e = 0; e < 6; e++) {
      const Real stress = stresses.of[e][i];
      Real first = h.of[0][e][at];
      TURGOR_UNROLL
      for (int p = 1; p < kFields; p++) {
        const Real before = h.of[p][e][at];
        first -= before;
        h.of[p][e][at] = before + steps.weight[p][i] * stress;
      }
      h.of[0][e][at] = first + steps.weight[0][i] * stress;
    }
  }
}
/// Hᵢ ← (Hᵢ + wᵢ S_old)/aᵢ, the inverse of decay_cells. A pair that relaxes within a step has no history that
/// the next one would keep.
template <int kFields, int kWidth>
void undo_decay(const HistoryEntries& history, int slot, const GroupSteps& steps,
                const LawStresses<kWidth>& stresses) {
  constexpr Real kLeastDecay = 1e-6f;
  const HistoryEntries h = history;
  for (int i = 0; i < kWidth; i++) {
    const int at = slot + i;
    for (int e = 0; e < 6; e++) {
      const auto before = [&](int p, Real decayed) {
        const Real decay = steps.decay[p][i];
        return decay > kLeastDecay ? (decayed + steps.weight[p][i] * stresses.of[e][i]) / decay : 0;
      };
      Real first = h.of[0][e][at];
      for (int p = 1; p < kFields; p++) {
        first -= h.of[p][e][at];
        h.of[p][e][at] = before(p, h.of[p][e][at]);
      }
      h.of[0][e][at] = before(0, first);
    }
  }
}
/// Calls f with the number of fields as a type.
template <class F>
void with_field_count(std::size_t fields, const F& f) {
  static_assert(kMostPronyPairs == 3, "a history has up to three pairs, and the set");
  switch (fields) {
    case 1:
      return f(std::integral_constant<int, 1>());
    case 2:
      return f(std::integral_constant<int, 2>());
    case 3:
      return f(std::integral_constant<int, 3>());
    default:
      return f(std::integral_constant<int, 4>());
  }
}

/// Lets the set of cells beside each other grow; `h`: entries of the field that holds −Q.
template <int kWidth>
void grow_set(const PermanentSet& set, double dt, const LawStresses<kWidth>& stresses, int slot,
              Real* const (&h)[6]) {
  const Real rate = Real(-std::expm1(-dt / set.time)), share = Real(set.share), yield = Real(set.strain);
  Real *xx = h[0] + slot, *yy = h[1] + slot, *zz = h[2] + slot, *xy = h[3] + slot, *xz = h[4] + slot,
       *yz = h[5] + slot;
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const Real excess = positive(1 - yield / nonzero(stresses.strain[i])), beyond = share * excess;
    // T, and T − Q
    Real target[6], more[6] = {xx[i], yy[i], zz[i], xy[i], xz[i], yz[i]}, along = 0;
    TURGOR_UNROLL
    for (int e = 0; e < 6; e++) {
      target[e] = beyond * stresses.of[e][i];
      more[e] += target[e];
      along += (e < 3 ? 1 : 2) * target[e] * more[e];
    }
    const Real by = along > 0 ? rate : 0;
    xx[i] -= by * more[0], yy[i] -= by * more[1], zz[i] -= by * more[2];
    xy[i] -= by * more[3], xz[i] -= by * more[4], yz[i] -= by * more[5];
  }
}

}  // namespace

std::vector<double> instant_factors(const Model& model, double dt) {
  std::vector<double> factors;
  for (const FieldSteps& one : AllSteps(model, dt).of) factors.push_back(instant_of(one));
  return factors;
}

void begin_viscous_step(const Exec& exec, const Model& model, State& state, double dt) {
  if (!is_viscous(model)) return;
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  const std::size_t fields = field_count(model.params.tissue);
  const AllSteps steps(model, dt);
  Viscosity& viscosity = state.viscosity;
  // memory
  if (viscosity.history.size() != fields) {
    viscosity.history.assign(fields, {});
    for (SymmetricField& field : viscosity.history)
      for (aligned_vector<Real>* entry : entries_of(field)) entry->assign(model.anatomy.cell_young.size(), 0);
  }
  // decay, and the old stress
  viscosity.in_step = false;
  const HistoryEntries history(viscosity.history);
  with_field_count(fields, [&]<int kFields>(std::integral_constant<int, kFields>) {
    for_each_stress(
        exec, model, state,
        [&]<int kWidth>(int slot, const Real(&young)[kWidth], const LawStresses<kWidth>& stresses) {
          GroupSteps own;
          const GroupSteps& of = steps.group(slot, kWidth, own);
          decay_cells<kFields>(history, slot, of, young, stresses);
        });
  });
  const std::vector<double> factors = instant_factors(model, dt);
  viscosity.instant = Real(factors[0]);
  viscosity.instants.clear();
  for (const std::uint8_t n : model.anatomy.cell_laws.relaxation)
    viscosity.instants.push_back(Real(factors[std::size_t(n)]));
  viscosity.in_step = true;
}

void end_viscous_step(const Exec& exec, const Model& model, State& state, double dt, bool finite) {
  if (!is_viscous(model)) return;
  const std::size_t fields = field_count(model.params.tissue);
  const AllSteps steps(model, dt);
  const PermanentSet& set = model.params.tissue.set;
  Viscosity& viscosity = state.viscosity;
  TURGOR_CHECK(viscosity.in_step && viscosity.history.size() == fields, "a viscous step has begun");
  viscosity.in_step = false;
  const HistoryEntries history(viscosity.history);
  with_field_count(fields, [&]<int kFields>(std::integral_constant<int, kFields>) {
    for_each_stress(exec, model, state,
                    [&]<int kWidth>(int slot, const Real(&)[kWidth], const LawStresses<kWidth>& stresses) {
                      GroupSteps own;
                      const GroupSteps& of = steps.group(slot, kWidth, own);
                      if (!finite) return undo_decay<kFields>(history, slot, of, stresses);
                      grow_cells<kFields>(history, slot, of, stresses);
                      if (has_set(set)) grow_set(set, dt, stresses, slot, history.of[kFields - 1]);
                    });
  });
}

double largest_set(const Exec& exec, const Model& model, const State& state) {
  if (!has_set(model.params.tissue.set) || state.viscosity.history.empty()) return 0;
  const SymmetricField& q = state.viscosity.history.back();
  const CellLaws& laws = model.anatomy.cell_laws;
  // by layer of slots, so that the sum does not depend on threads
  const Lattice& l = model.anatomy.lattice;
  std::vector<double> most(std::size_t(l.size.z), 0);
  parallel_for(exec, most.size(), [&](std::size_t k) {
    const auto begin = std::size_t(row_slot(l, -1, int(k)));
    for (std::size_t s = begin; s < begin + std::size_t(layer_stride(l)); s++) {
      const double shear = double(model.anatomy.cell_young[s]) * double(laws.shear[s]);
      if (!(shear > 0)) continue;
      const double xx = double(q.xx[s]), yy = double(q.yy[s]), zz = double(q.zz[s]),
                   mean = (xx + yy + zz) / 3;
      const double square = (xx - mean) * (xx - mean) + (yy - mean) * (yy - mean) +
                            (zz - mean) * (zz - mean) +
                            2 * (double(q.xy[s]) * double(q.xy[s]) + double(q.xz[s]) * double(q.xz[s]) +
                                 double(q.yz[s]) * double(q.yz[s]));
      // the neo-Hookean law's modulus is 4/3 µ
      const SolidEnergy energy =
          laws.energy.empty() ? model.params.tissue.energy : SolidEnergy(laws.energy[s]);
      const double mu = shear * hourglass_over_shear(energy) / 4;
      most[k] = std::max(most[k], std::sqrt(2.0 / 3 * square) / (2 * mu));
    }
  });
  return *std::max_element(most.begin(), most.end());
}

}  // namespace turgor::lattice
