// Kernels of the linear system of a step, W Δv = h f̃ (system.hpp): assembly, sweeps, residual. Each handles
// one vertex (or sixteen), in any order.
#pragma once

#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

/// Smallest eigenvalue of a diagonal block that single precision resolves, relative to its trace.
constexpr float kLeastEigenvalue = 1e-6f;

/// Preconditioner for a diagonal block, from the factors L D Lᵀ. `least` bounds its eigenvalues from below. A
/// block that is much stiffer in one direction than in another is shifted, so that rounding keeps the inverse
/// positive definite. The cofactors of inverse() would cancel; sweeps keep inverse(), whose bits their
/// validation has.
template <class T>
TURGOR_HD inline Symmetric<T> definite_inverse(Symmetric<T> m, T least) {
  // scale to a trace of 1, and shift
  const T scale = 1 / (m.diagonal.x + m.diagonal.y + m.diagonal.z), limit = all_of<T>(kLeastEigenvalue);
  const T shift = larger(limit - least * scale, all_of<T>(0));
  const auto [b, c, e] = m.off * scale;
  // factors
  const T d1 = m.diagonal.x * scale + shift, l21 = b / d1, l31 = c / d1;
  const T d2 = larger(m.diagonal.y * scale + shift - b * l21, limit), l32 = (e - c * l21) / d2;
  const T d3 = larger(m.diagonal.z * scale + shift - c * l31 - l32 * l32 * d2, limit);
  // L⁻ᵀ D⁻¹ L⁻¹
  const T i1 = scale / d1, i2 = scale / d2, i3 = scale / d3, w = l21 * l32 - l31;
  return {Three<T>{i1 + l21 * l21 * i2 + w * w * i3, i2 + l32 * l32 * i3, i3},
          Three<T>{-l21 * i2 - w * l32 * i3, w * i3, -l32 * i3}};
}

/// Assembles the row of a vertex: force with stretch damping, matrix entries, and inverse diagonal block.
template <class T>
struct AssembleRow {
  SheetView sheet;
  Vec3 gravity;
  Real dt, motion_damping;  // h [s]; h·motion damping [1]
  bool has_air, keeps_air;
  bool preconditions;  // the inverse diagonal is a preconditioner of conjugate gradients

  /// Springs with the energy ½ k (L − L₀)²: force k (1 − L₀/L) e, and J = k [n nᵀ + max(0, 1 − L₀/L) (I − n
  /// nᵀ)], with e the vector to the neighbor and n its direction. `least` grows by the isotropic part of d.
  TURGOR_HD static void add_springs(const SheetView s, Real dt, std::size_t i, const Three<T>& x,
                                    const Three<T>& v, T is_free, Three<T>& f, Symmetric<T>& d, T& least) {
    const RowsView& rows = s.rows;
    for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
      const std::size_t entry = entry_of<T>(slot, i);
      const Three<T> e = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, s.v, slot, i) - v;
      const T k = load<T>(rows.stiffness, entry);
      const T length2 = larger(dot(e, e), all_of<T>(1e-20f));
      const T stretch = 1 - load<T>(rows.rest, entry) / square_root(length2);
      // Compressed springs lose the transverse term, so that W stays positive definite [Kang III].
      const T across = k * s.stiffness_factor * larger(stretch, all_of<T>(0));
      const T along = (k * s.stiffness_factor - across) / length2;
      f = f + e * (k * dt * stretch + along * dot(e, u)) + u * across;
      d.diagonal = d.diagonal + Three<T>{along * e.x * e.x + across, along * e.y * e.y + across,
                                         along * e.z * e.z + across};
      d.off = d.off + Three<T>{along * e.x * e.y, along * e.x * e.z, along * e.y * e.z};
      least = least + across;
      store<T>(s.along, entry, along * is_free);
      store<T>(s.across, entry, across * is_free);
    }
  }

  /// Sheet: forces from the membrane tensions in `across`, τ e, and bending. J bounds the membrane stiffness
  /// by springs along the edges. Compressed edges lose the transverse term. `least` as in add_springs.
  TURGOR_HD static void add_sheet(const SheetView s, Real dt, std::size_t i, const Three<T>& x,
                                  const Three<T>& v, T is_free, Three<T>& f, Symmetric<T>& d, T& least) {
    const RowsView &rows = s.rows, &far = s.far;
    const T extra_diagonal = load<T>(s.extra_diagonal, i) * s.stiffness_factor;
    T sum = extra_diagonal;
    for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
      const std::size_t entry = entry_of<T>(slot, i);
      const Three<T> e = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, s.v, slot, i) - v;
      const T tension = load<T>(s.across, entry), bend = load<T>(rows.bend, entry);
      const T across = (larger(tension, all_of<T>(0)) + bend) * s.stiffness_factor;
      const T along =
          load<T>(rows.stiffness, entry) * s.stiffness_factor / larger(dot(e, e), all_of<T>(1e-20f));
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
      f = f + e * (bend * dt) + u * (bend * s.stiffness_factor);
      sum = sum + bend * s.stiffness_factor;
    }
    d.diagonal = d.diagonal + Three<T>{sum, sum, sum};
    least = least + sum;
  }

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    // inertia, weight and damping of motion
    const Three<T> x = load<T>(sheet.x, i), v = load<T>(sheet.v, i);
    const T mass = load<T>(sheet.free_mass, i);
    const T is_free = cloth::is_free<T>(sheet, i);
    T least = mass * (1 + motion_damping);  // of the eigenvalues of d
    Symmetric<T> d{{least, least, least}, {}};
    Three<T> f = Three<T>{mass * gravity.x, mass * gravity.y, mass * gravity.z} * all_of<T>(dt) -
                 v * (mass * motion_damping);
    // wind
    if (keeps_air)
      for (int k = 0; k < 2; k++)
        store<T>(sheet.air[k], i, has_air ? load<T>(sheet.inverse[k], i) * is_free : Three<T>{});
    if (has_air) {
      f = f + load<T>(sheet.force, i);
      d.diagonal = d.diagonal + load<T>(sheet.inverse[0], i), d.off = d.off + load<T>(sheet.inverse[1], i);
    }
    // springs or sheet
    if (sheet.is_sheet())
      add_sheet(sheet, dt, i, x, v, is_free, f, d, least);
    else
      add_springs(sheet, dt, i, x, v, is_free, f, d, least);
    const T is_held = 1 - is_free;  // row of a held vertex: its change is given
    d = {d.diagonal * is_free + Three<T>{is_held, is_held, is_held}, d.off * is_free};
    const Symmetric<T> inverted =
        preconditions ? definite_inverse<T>(d, least * is_free + is_held) : inverse(d);
    store<T>(sheet.inverse[0], i, inverted.diagonal), store<T>(sheet.inverse[1], i, inverted.off);
    store<T>(sheet.force, i, f * is_free);
  }
};

/// Right-hand side of Jacobi's method: force + s Σ J_ij a_j, plus a_i times the excess of the diagonal over
/// W's.
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
  Three<T> bend = load<T>(a, i) * load<T>(s.extra_diagonal, i);
  for (int slot = far.begin(i); slot < far.end(i); slot++)
    bend = bend + neighbors<T>(far, a, slot, i) * load<T>(far.bend, entry_of<T>(slot, i));
  return sum + bend * (is_free<T>(s, i) * s.stiffness_factor);
}

/// previous ← previous + omega (W_ii⁻¹ (force + s Σ J_ij change_j) − previous)
template <class T>
struct SweepRow {
  SheetView s;
  Real omega;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> sum = with_neighbors<T>(s, s.change, i, load<T>(s.force, i));
    const Three<T> before = load<T>(s.previous, i);
    const Three<T> jacobi = inverse_diagonal<T>(s, i) * sum;
    store<T>(s.previous, i, before + (jacobi - before) * all_of<T>(omega));
  }
};

/// force − W a with the sum changed by add_terms; 0 for held vertices. It uses differences of neighbors,
/// since a stiff matrix with light masses would round them away.
template <class T, class AddTerms>
TURGOR_HD inline Three<T> residual_forces(const SheetView& s, Real mass_factor, ConstVectorsView a,
                                          Three<T> force, std::size_t i, const AddTerms& add_terms) {
  const RowsView &rows = s.rows, &far = s.far;
  const Three<T> x = load<T>(s.x, i), mine = load<T>(a, i);
  const T mass = load<T>(s.free_mass, i);
  const Symmetric<T> air{load<T>(s.air[0], i), load<T>(s.air[1], i)};
  Three<T> sum = force - mine * (mass * mass_factor) - air * mine;
  for (int slot = rows.begin(i); slot < rows.end(i); slot++) {
    const Three<T> d = neighbors<T>(rows, s.x, slot, i) - x, u = neighbors<T>(rows, a, slot, i) - mine;
    const std::size_t entry = entry_of<T>(slot, i);
    sum = sum + d * (load<T>(s.along, entry) * dot(d, u)) + u * load<T>(s.across, entry);
  }
  Three<T> bend{};
  if (s.is_sheet())
    for (int slot = far.begin(i); slot < far.end(i); slot++)
      bend = bend + (neighbors<T>(far, a, slot, i) - mine) * load<T>(far.bend, entry_of<T>(slot, i));
  return (add_terms(sum) + bend * all_of<T>(s.stiffness_factor)) * is_free<T>(s, i);
}

/// Runs the sweeps of a step: sweep(omega) for each, and settle(), which copies `previous` to `change`.
template <class Sweep, class Settle>
void run_sweeps(bool accelerated, int sweeps, const Sweep& sweep, const Settle& settle) {
  int remaining = sweeps + 1;  // the paper's start, W_ii⁻¹ h f̃, is a sweep too
  if (remaining % 2 == 1) {    // an odd number would double errors of alternating sign [docs/models/cloth.md]
    sweep(Real(0.5));
    remaining--;
    settle();
  }
  if (!accelerated) {
    for (; remaining > 0; remaining--) sweep(Real(1));
    return;
  }
  // Chebyshev weights: errors of eigenvalues in [-rho, rho] shrink to 1/(2 + sweeps), none grows, and the
  // slow ones above rho are reduced as far as possible.
  const double rho = 1 / std::cosh(std::acosh(2.0 + remaining) / remaining);
  double omega = 1;
  for (int n = 0; n < remaining; n++) {
    sweep(Real(omega));
    omega = n == 0 ? 2 / (2 - rho * rho) : 4 / (4 - rho * rho * omega);
  }
}

}  // namespace turgor::cloth
