// Kernels for velocities and positions in a step. Each handles one vertex (or sixteen), in any order.
#pragma once

#include "turgor/models/cloth/model/sheet_view.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// BDF2 predictor (step.cpp): x₁ + (x₁ − x₀)/3. `before` becomes x₁.
template <class T>
struct PredictBdf2 {
  VectorsView now, before;
  bool has_history;  // false: `now` stays, for lack of a history

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> one = load<T>(now, i), zero = load<T>(before, i);
    store<T>(before, i, one);
    if (has_history) store<T>(now, i, one + (one - zero) * all_of<T>(1.0f / 3));
  }
};

template <class T>
struct ChangeVelocities {
  VectorsView v;
  ConstVectorsView change;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    store<T>(v, i, load<T>(v, i) + load<T>(change, i));
  }
};

/// The same, and keeps the velocities before it.
struct ChangeVelocitiesReversibly {
  VectorsView v;
  ConstVectorsView change;
  VectorsView before;

  TURGOR_HD void operator()(std::size_t n) const { before.set(n, v[n]), v.set(n, v[n] + change[n]); }
};

constexpr int kStrainPasses = 12;
inline Real strain_limit(const Model& model) { return Real(1 + model.params.solver.strain_limit); }

/// One Jacobi pass of the strain limit |d| ≤ limit · L₀ with d the vector of a spring at the end of the step.
/// The correction of a spring is (|d| − limit L₀) n / h, split between its free ends; a vertex takes the mean
/// over its long springs. New velocities go to System::previous.
template <class T>
struct LimitStrain {
  SheetView s;
  Real limit, h;  // [1] [s]

  /// Rest length of a spring; the rows of a sheet do not store it.
  TURGOR_HD T rest_length(std::size_t i, int slot) const {
    if (s.rows.rest != nullptr) return load<T>(s.rows.rest, entry_of<T>(slot, i));
    const Three<T> d = neighbors<T>(s.rows, s.x_rest, slot, i) - load<T>(s.x_rest, i);
    return square_root(dot(d, d));
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const RowsView& rows = s.rows;
    // excess of each spring
    const Three<T> x = load<T>(s.x, i), v = load<T>(s.v, i);
    const T mass = load<T>(s.free_mass, i);
    const T zero = all_of<T>(0), one = all_of<T>(1);
    Three<T> change{};
    T springs = zero;
    for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
      const Three<T> u = neighbors<T>(rows, s.v, slot, i) - v;
      const Three<T> d = neighbors<T>(rows, s.x, slot, i) - x + u * all_of<T>(h);
      const T length = square_root(larger(dot(d, d), all_of<T>(1e-20f)));
      const T excess = larger(1 - limit * rest_length(i, slot) / length, zero);
      const T counts = load<T>(rows.stiffness, entry_of<T>(slot, i)) > 0 ? one : zero;
      const T is_long = excess > 0 ? counts : zero;
      const T other = neighbors<T>(rows, s.free_mass, slot, i);
      const T fraction = other > 0 ? all_of<T>(0.5f) : one;  // a held neighbor does not move
      change = change + d * (is_long * excess * fraction / h);
      springs = springs + is_long;
    }
    // mean of the corrections
    const T share = mass > 0 ? one / larger(springs, one) : zero;
    store<T>(s.previous, i, v + change * share);
  }
};

/// Moves positions by v dt; `before` becomes `from`, the positions at the beginning of the step.
template <class T>
struct Move {
  VectorsView x;
  ConstVectorsView v, from;
  VectorsView before;
  Real dt;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> position = load<T>(x, i);
    store<T>(before, i, load<T>(from, i));
    store<T>(x, i, position + load<T>(v, i) * all_of<T>(dt));
  }
};

/// Velocity change of held vertices, which reaches their goals.
struct AimHolds {
  SheetView sheet;
  const Hold* holds;
  Real dt;

  TURGOR_HD void operator()(std::size_t n) const {
    const auto v = std::size_t(holds[n].vertex);
    sheet.force.set(v, (holds[n].goal - sheet.x[v]) / dt - sheet.v[v]);
  }
};
/// Initial guess of held vertices.
struct StartHolds {
  SheetView sheet;
  const Hold* holds;

  TURGOR_HD void operator()(std::size_t n) const {
    const auto v = std::size_t(holds[n].vertex);
    sheet.change.set(v, sheet.force[v]), sheet.previous.set(v, sheet.force[v]);
  }
};
/// Moves held vertices to their goals exactly.
struct MoveHolds {
  SheetView sheet;
  const Hold* holds;

  TURGOR_HD void operator()(std::size_t n) const { sheet.x.set(std::size_t(holds[n].vertex), holds[n].goal); }
};

/// Calls a kernel for every held vertex, on the host.
template <class Kernel>
void for_holds(const State& state, const Kernel& kernel) {
  for (std::size_t n = 0; n < state.holds.size(); n++) kernel(n);
}

}  // namespace turgor::cloth
