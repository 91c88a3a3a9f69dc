// Plain-pointer views of a sheet and of its linear system, for the kernels of host and device. Kernels are
// templates over the number of vertices they process: sixteen (T = Lanes, on a CPU) or one (T = Real, a GPU
// thread). The index `i` is that of the first vertex.
#pragma once

#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Model;
struct State;

/// Number of vertices in a T.
template <class T>
constexpr std::size_t kAtOnce = std::is_same_v<T, Lanes> ? std::size_t(kLanes) : 1;

template <class T>
TURGOR_HD inline T all_of(Real value) {
  if constexpr (kAtOnce < T >> 1)
    return all_lanes(value);
  else
    return value;
}
template <class T>
TURGOR_HD inline T load(const Real* from, std::size_t i) {
  if constexpr (kAtOnce < T >> 1)
    return load_lanes(from + i);
  else
    return from[i];
}
template <class T>
TURGOR_HD inline void store(Real* to, std::size_t i, T a) {
  if constexpr (kAtOnce < T >> 1)
    store_lanes(to + i, a);
  else
    to[i] = a;
}

/// Read-only vectors.
struct ConstVectorsView {
  const Real *x, *y, *z;

  TURGOR_HD Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
};
struct VectorsView {
  Real *x, *y, *z;

  TURGOR_HD operator ConstVectorsView() const { return {x, y, z}; }
  TURGOR_HD Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  TURGOR_HD void set(std::size_t i, Vec3 a) const { x[i] = a.x, y[i] = a.y, z[i] = a.z; }
  TURGOR_HD void add(std::size_t i, Vec3 a) const { x[i] += a.x, y[i] += a.y, z[i] += a.z; }
};
inline VectorsView view(Vectors& a) { return {a.x.data(), a.y.data(), a.z.data()}; }
inline ConstVectorsView view(const Vectors& a) { return {a.x.data(), a.y.data(), a.z.data()}; }

template <class T>
TURGOR_HD inline Three<T> load(ConstVectorsView a, std::size_t i) {
  return {load<T>(a.x, i), load<T>(a.y, i), load<T>(a.z, i)};
}
template <class T>
TURGOR_HD inline void store(VectorsView a, std::size_t i, Three<T> b) {
  store<T>(a.x, i, b.x), store<T>(a.y, i, b.y), store<T>(a.z, i, b.z);
}

inline Lanes3 gather(ConstVectorsView a, const int* index) {
  return {gather_lanes(a.x, index), gather_lanes(a.y, index), gather_lanes(a.z, index)};
}

/// View of Rows; null pointers for empty arrays.
struct RowsView {
  const int *slot_begin, *first, *gathered;
  const Real *rest, *stiffness, *bend;

  TURGOR_HD int begin(std::size_t i) const { return slot_begin[i / std::size_t(kLanes)]; }
  TURGOR_HD int end(std::size_t i) const { return slot_begin[i / std::size_t(kLanes) + 1]; }
};
inline RowsView view(const Rows& rows) {
  const auto pointer = [](const auto& list) { return list.empty() ? nullptr : list.data(); };
  return {pointer(rows.slot_begin), pointer(rows.first),     pointer(rows.gathered),
          pointer(rows.rest),       pointer(rows.stiffness), pointer(rows.bend)};
}

/// Index of the coefficient of vertex i in a slot.
template <class T>
TURGOR_HD inline std::size_t entry_of(int slot, std::size_t i) {
  const std::size_t entry = std::size_t(slot) * std::size_t(kLanes);
  return kAtOnce<T> == 1 ? entry + i % std::size_t(kLanes) : entry;
}
/// Values of the neighbors in a slot.
template <class T>
TURGOR_HD inline T neighbors(const RowsView& rows, const Real* a, int slot, std::size_t i) {
  const int first = rows.first[slot];
  if constexpr (kAtOnce < T >> 1) {
    return first >= 0 ? load_lanes(a + first) : gather_lanes(a, rows.gathered - 1 - first);
  } else {
    const int lane = int(i % std::size_t(kLanes));
    return a[first >= 0 ? first + lane : rows.gathered[lane - 1 - first]];
  }
}
template <class T>
TURGOR_HD inline Three<T> neighbors(const RowsView& rows, ConstVectorsView a, int slot, std::size_t i) {
  return {neighbors<T>(rows, a.x, slot, i), neighbors<T>(rows, a.y, slot, i),
          neighbors<T>(rows, a.z, slot, i)};
}

/// View of model and state.
struct SheetView {
  std::size_t size;  // vertices, padded to whole batches
  RowsView rows, far;
  const Real* extra_diagonal;  // null for springs
  ConstVectorsView x_rest;
  VectorsView x, v;
  const Real* free_mass;
  Real *along, *across;
  VectorsView force, inverse[2], change, previous, air[2];
  Real stiffness_factor;  // System::square

  TURGOR_HD bool is_sheet() const { return extra_diagonal != nullptr; }
};
SheetView view(const Model& model, State& state);

template <class T>
TURGOR_HD inline T is_free(const SheetView& sheet, std::size_t i) {
  return load<T>(sheet.free_mass, i) > 0 ? all_of<T>(1) : all_of<T>(0);
}
template <class T>
TURGOR_HD inline Symmetric<T> inverse_diagonal(const SheetView& sheet, std::size_t i) {
  return {load<T>(sheet.inverse[0], i), load<T>(sheet.inverse[1], i)};
}

}  // namespace turgor::cloth
