// Velocities and places in a step: what is done to every vertex, in any order.
#pragma once

#include "turgor/models/cloth/device/sheet_view.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

/// Of the two-step formula (step.cpp): from the step before and this one to where both lead.
template <class T>
struct LeadOn {
  VectorsView now, before;
  bool leads;  // else this one alone is known

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> one = load<T>(now, i), zero = load<T>(before, i);
    store<T>(before, i, one);
    if (leads) store<T>(now, i, one + (one - zero) * all_of<T>(1.0f / 3));
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

constexpr int kStrainPasses = 12;
inline Real strain_limit(const Model& model) { return Real(1 + model.params.solver.strain_limit); }

/// Springs that would be longer than `limit` times their rest length: the velocities without what makes them
/// so go into `before`.
template <class T>
struct LimitStrain {
  SheetView s;
  Real limit, h;  // [1] [s]

  /// A sheet's rows do not keep them.
  TURGOR_HD T rest_length(std::size_t i, int slot) const {
    if (s.rows.rest != nullptr) return load<T>(s.rows.rest, entry_of<T>(slot, i));
    const Three<T> d = neighbors<T>(s.rows, s.x_rest, slot, i) - load<T>(s.x_rest, i);
    return square_root(dot(d, d));
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const RowsView& rows = s.rows;
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
      const T part = other > 0 ? all_of<T>(0.5f) : one;  // a held neighbour does nothing
      change = change + d * (is_long * excess * part / h);
      springs = springs + is_long;
    }
    const T share = mass > 0 ? one / larger(springs, one) : zero;
    store<T>(s.before, i, v + change * share);
  }
};

/// Places from where the step began, which go into `before`.
template <class T>
struct Move {
  VectorsView x;
  ConstVectorsView v, from;
  VectorsView before;
  Real dt;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    const Three<T> place = load<T>(x, i);
    store<T>(before, i, load<T>(from, i));
    store<T>(x, i, place + load<T>(v, i) * all_of<T>(dt));
  }
};

}  // namespace turgor::cloth
