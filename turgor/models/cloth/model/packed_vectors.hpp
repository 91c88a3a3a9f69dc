// Vectors per vertex stored one after the other, four numbers each, and loops over eight vertices. A slot of
// neighbors that are not consecutive takes eight loads of whole vectors instead of 24 of single numbers.
// Eight numbers fit into a register of AVX2, where sixteen are kept in memory.
#pragma once

#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

/// x, y, z and 0 of every vertex.
using PackedVectors = aligned_vector<Real>;

using Eight = float __attribute__((vector_size(32)));
/// Three components of eight vertices.
struct Eight3 {
  Eight x, y, z;
};
inline Eight3 operator+(Eight3 a, Eight3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Eight3 operator-(Eight3 a, Eight3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Eight3 operator*(Eight3 a, Eight s) { return {a.x * s, a.y * s, a.z * s}; }
inline Eight dot(Eight3 a, Eight3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

namespace detail {

using Four = float __attribute__((vector_size(16)));
using AnyFour = float __attribute__((vector_size(16), aligned(4), may_alias));
using AnyEight = float __attribute__((vector_size(32), aligned(4), may_alias));

/// a0 b0 a1 b1 and a2 b2 a3 b3 of both halves.
inline Eight low_pairs(Eight a, Eight b) { return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13); }
inline Eight high_pairs(Eight a, Eight b) {
  return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
}
/// a0 a1 b0 b1 and a2 a3 b2 b3 of both halves.
inline Eight low_twos(Eight a, Eight b) { return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13); }
inline Eight high_twos(Eight a, Eight b) { return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15); }

}  // namespace detail

inline Eight load_eight(const Real* from) { return *reinterpret_cast<const detail::AnyEight*>(from); }
inline void store_eight(Real* to, Eight a) { *reinterpret_cast<detail::AnyEight*>(to) = a; }
inline Eight3 load_eight(const Real* x, const Real* y, const Real* z) {
  return {load_eight(x), load_eight(y), load_eight(z)};
}

/// Vectors of the eight vertices index[0], index[1], …
inline Eight3 gather_eight(const Real* packed, const int* index) {
  using namespace detail;
  // vertices n and n + 4 in one row, transposed
  const auto row = [&](int n) {
    const Four low = *reinterpret_cast<const AnyFour*>(packed + 4 * std::ptrdiff_t(index[n])),
               high = *reinterpret_cast<const AnyFour*>(packed + 4 * std::ptrdiff_t(index[n + 4]));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Eight a = row(0), b = row(1), c = row(2), d = row(3);
  const Eight ab = low_pairs(a, b), cd = low_pairs(c, d);
  return {low_twos(ab, cd), high_twos(ab, cd), low_twos(high_pairs(a, b), high_pairs(c, d))};
}

/// Stores the vectors of the eight vertices from i on.
inline void store_packed(PackedVectors& to, std::size_t i, Eight3 a) {
  using namespace detail;
  const Eight xy = low_pairs(a.x, a.y), zero = low_pairs(a.z, Eight{}), more_xy = high_pairs(a.x, a.y),
              more_zero = high_pairs(a.z, Eight{});
  const auto put = [&to, i](std::size_t n, Eight rows) {
    *reinterpret_cast<AnyFour*>(&to[4 * (i + n)]) = __builtin_shufflevector(rows, rows, 0, 1, 2, 3);
    *reinterpret_cast<AnyFour*>(&to[4 * (i + n + 4)]) = __builtin_shufflevector(rows, rows, 4, 5, 6, 7);
  };
  put(0, low_twos(xy, zero)), put(1, high_twos(xy, zero));
  put(2, low_twos(more_xy, more_zero)), put(3, high_twos(more_xy, more_zero));
}

}  // namespace turgor::cloth
