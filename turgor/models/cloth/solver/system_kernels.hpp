// The linear system of a step, W Δv = h f̃ (system.hpp), and its sweeps: what is done to every vertex, in any
// order.
#pragma once

#include "turgor/models/cloth/device/sheet_view.hpp"

namespace turgor::cloth {

/// Forces of springs around a vertex, viscous part included, their matrix entries, and the inverse of the
/// diagonal block.
template <class T>
struct AssembleRow {
  SheetView sheet;
  Vec3 gravity;
  Real dt, keep;  // h [s]; h·motion damping [1]
  bool has_air, keeps_air;

  TURGOR_HD static void add_springs(const SheetView s, Real dt, std::size_t i, const Three<T>& x,
                                    const Three<T>& v, T is_free, Three<T>& f, Symmetric<T>& d) {
    const RowsView& rows = s.rows;
    for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
      const std::size_t entry = entry_of<T>(slot, i);
      const Three<T> e = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, s.v, slot, i) - v;
      const T k = load<T>(rows.stiffness, entry);
      const T length2 = larger(dot(e, e), all_of<T>(1e-20f));
      const T stretch = 1 - load<T>(rows.rest, entry) / square_root(length2);
      // Compressed springs lose the part across them, so that W stays positive definite. [Kang III]
      const T across = k * s.square * larger(stretch, all_of<T>(0));
      const T along = (k * s.square - across) / length2;
      f = f + e * (k * dt * stretch + along * dot(e, u)) + u * across;
      d.diagonal = d.diagonal + Three<T>{along * e.x * e.x + across, along * e.y * e.y + across,
                                         along * e.z * e.z + across};
      d.off = d.off + Three<T>{along * e.x * e.y, along * e.x * e.z, along * e.y * e.z};
      store<T>(s.along, entry, along * is_free);
      store<T>(s.across, entry, across * is_free);
    }
  }

  /// The tensions of the membrane are in `across`. Its stiffness is bounded by springs along the edges; those
  /// that are pushed lose the part across them, as springs do.
  TURGOR_HD static void add_sheet(const SheetView s, Real dt, std::size_t i, const Three<T>& x,
                                  const Three<T>& v, T is_free, Three<T>& f, Symmetric<T>& d) {
    const RowsView &rows = s.rows, &far = s.far;
    const T spare = load<T>(s.spare, i) * s.square;
    T sum = spare;
    for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
      const std::size_t entry = entry_of<T>(slot, i);
      const Three<T> e = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, s.v, slot, i) - v;
      const T tension = load<T>(s.across, entry), bend = load<T>(rows.bend, entry);
      const T across = (larger(tension, all_of<T>(0)) + bend) * s.square;
      const T along = load<T>(rows.stiffness, entry) * s.square / larger(dot(e, e), all_of<T>(1e-20f));
      f = f + e * ((tension + bend) * dt + along * dot(e, u)) + u * across;
      d.diagonal = d.diagonal + Three<T>{along * e.x * e.x, along * e.y * e.y, along * e.z * e.z};
      d.off = d.off + Three<T>{along * e.x * e.y, along * e.x * e.z, along * e.y * e.z};
      sum = sum + across;
      store<T>(s.along, entry, along * is_free);
      store<T>(s.across, entry, across * is_free);
    }
    for (int slot = far.begin(i); slot < far.end(i); slot++) {
      const Three<T> e = neighbors<T>(far, s.x, slot, i) - x, u = neighbors<T>(far, s.v, slot, i) - v;
      const T bend = load<T>(far.bend, entry_of<T>(slot, i));
      f = f + e * (bend * dt) + u * (bend * s.square);
      sum = sum + bend * s.square;
    }
    d.diagonal = d.diagonal + Three<T>{sum, sum, sum};
  }

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> x = load<T>(sheet.x, i), v = load<T>(sheet.v, i);
    const T mass = load<T>(sheet.free_mass, i);
    const T is_free = cloth::is_free<T>(sheet, i);
    Symmetric<T> d{{mass * (1 + keep), mass * (1 + keep), mass * (1 + keep)}, {}};
    Three<T> f =
        Three<T>{mass * gravity.x, mass * gravity.y, mass * gravity.z} * all_of<T>(dt) - v * (mass * keep);
    if (keeps_air)
      for (int k = 0; k < 2; k++)
        store<T>(sheet.air[k], i, has_air ? load<T>(sheet.inverse[k], i) * is_free : Three<T>{});
    if (has_air) {
      f = f + load<T>(sheet.force, i);
      d.diagonal = d.diagonal + load<T>(sheet.inverse[0], i), d.off = d.off + load<T>(sheet.inverse[1], i);
    }
    if (sheet.is_sheet())
      add_sheet(sheet, dt, i, x, v, is_free, f, d);
    else
      add_springs(sheet, dt, i, x, v, is_free, f, d);
    const T is_held = 1 - is_free;  // whose row says: the change is the given one
    d = {d.diagonal * is_free + Three<T>{is_held, is_held, is_held}, d.off * is_free};
    const Symmetric<T> inverted = inverse(d);
    store<T>(sheet.inverse[0], i, inverted.diagonal), store<T>(sheet.inverse[1], i, inverted.off);
    store<T>(sheet.force, i, f * is_free);
  }
};

/// What Jacobi's method sees on its right-hand side: force + s Σ J_ij a_j, and what the diagonal has beyond
/// W's times a_i.
template <class T>
TURGOR_HD inline Three<T> with_neighbors(const SheetView s, ConstVectorsView a, std::size_t i, Three<T> sum) {
  const RowsView &rows = s.rows, &far = s.far;
  const Three<T> x = load<T>(s.x, i);
  for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
    const Three<T> d = neighbors<T>(rows, s.x, slot, i) - x, other = neighbors<T>(rows, a, slot, i);
    const std::size_t entry = entry_of<T>(slot, i);
    sum = sum + d * (load<T>(s.along, entry) * dot(d, other)) + other * load<T>(s.across, entry);
  }
  if (!s.is_sheet()) return sum;
  Three<T> bend = load<T>(a, i) * load<T>(s.spare, i);
  for (int slot = far.begin(i); slot < far.end(i); slot++)
    bend = bend + neighbors<T>(far, a, slot, i) * load<T>(far.bend, entry_of<T>(slot, i));
  return sum + bend * (is_free<T>(s, i) * s.square);
}

/// before = before + omega (W_ii⁻¹ (force + s Σ J_ij change_j) − before)
template <class T>
struct SweepRow {
  SheetView s;
  Real omega;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> sum = with_neighbors<T>(s, s.change, i, load<T>(s.force, i));
    const Three<T> before = load<T>(s.before, i);
    const Three<T> jacobi = inverse_diagonal<T>(s, i) * sum;
    store<T>(s.before, i, before + (jacobi - before) * all_of<T>(omega));
  }
};

/// force − W a, with what `others` add to the springs' sum; 0 for held vertices. Differences of neighbours
/// keep what a stiff matrix with a light mass on its diagonal would round away.
template <class T, class HaloExchange>
TURGOR_HD inline Three<T> residual_forces(const SheetView& s, Real keep, ConstVectorsView a, Three<T> force,
                                          std::size_t i, const HaloExchange& others) {
  const RowsView &rows = s.rows, &far = s.far;
  const Three<T> x = load<T>(s.x, i), mine = load<T>(a, i);
  const T mass = load<T>(s.free_mass, i);
  const Symmetric<T> air{load<T>(s.air[0], i), load<T>(s.air[1], i)};
  Three<T> sum = force - mine * (mass * keep) - air * mine;
  for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
    const Three<T> d = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, a, slot, i) - mine;
    const std::size_t entry = entry_of<T>(slot, i);
    sum = sum + d * (load<T>(s.along, entry) * dot(d, u)) + u * load<T>(s.across, entry);
  }
  Three<T> bend{};
  if (s.is_sheet())
    for (int slot = far.begin(i); slot < far.end(i); slot++)
      bend = bend + (neighbors<T>(far, a, slot, i) - mine) * load<T>(far.bend, entry_of<T>(slot, i));
  return (others(sum) + bend * all_of<T>(s.square)) * is_free<T>(s, i);
}

/// All the sweeps of a step: sweep(omega), and settle() where `before` becomes `change`.
template <class Sweep, class Settle>
void go_through_sweeps(bool accelerated, int sweeps, const Sweep& sweep, const Settle& settle) {
  int left = sweeps + 1;  // the paper's start, W_ii⁻¹ h f̃, is a sweep too
  if (left % 2 == 1) {    // errors of alternating sign would come out doubled [docs/models/cloth.md]
    sweep(Real(0.5));
    left--;
    settle();
  }
  if (!accelerated) {
    for (; left > 0; left--) sweep(Real(1));
    return;
  }
  // Eigenvalues of the iteration in [-rho, rho] lose all but 1/(2 + sweeps) of their error, none grows, and
  // the slow ones above rho gain as much as they can.
  const double rho = 1 / std::cosh(std::acosh(2.0 + left) / left);
  double omega = 1;
  for (int n = 0; n < left; n++) {
    sweep(Real(omega));
    omega = n == 0 ? 2 / (2 - rho * rho) : 4 / (4 - rho * rho * omega);
  }
}

}  // namespace turgor::cloth
