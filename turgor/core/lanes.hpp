// Sixteen floats that are computed at once, for kernels whose arrays the compiler cannot vectorize. The
// operators are vector extensions of GCC and Clang, which split them on processors with narrower registers.
// Kernels that are templates over Lanes or float use the same function names for both.
#pragma once

#include <cmath>
#include <cstring>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include "turgor/core/config.hpp"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // all functions are inline and cross no ABI
#endif

namespace turgor {

constexpr int kLanes = 16;
using Lanes = float __attribute__((vector_size(4 * kLanes)));

inline Lanes all_lanes(float value) { return Lanes{} + value; }

inline Lanes load_lanes(const float* from) {
  Lanes a;
  std::memcpy(&a, from, sizeof a);
  return a;
}
inline void store_lanes(float* to, Lanes a) { std::memcpy(to, &a, sizeof a); }

/// from[index[0]], from[index[1]], …
inline Lanes gather_lanes(const float* from, const int* index) {
#ifdef __AVX512F__
  return Lanes(_mm512_i32gather_ps(_mm512_loadu_si512(index), from, 4));
#else
  Lanes a;
  for (int l = 0; l < kLanes; l++) a[l] = from[index[l]];
  return a;
#endif
}

inline Lanes square_root(Lanes a) {
#ifdef __AVX512F__
  return Lanes(_mm512_sqrt_ps(__m512(a)));
#else
  for (int l = 0; l < kLanes; l++) a[l] = __builtin_sqrtf(a[l]);
  return a;
#endif
}

/// Bit l is set when lane l of a is below b.
inline unsigned lanes_below(Lanes a, float b) {
#ifdef __AVX512F__
  return _mm512_cmp_ps_mask(__m512(a), _mm512_set1_ps(b), _CMP_LT_OQ);
#else
  unsigned bits = 0;
  for (int l = 0; l < kLanes; l++) bits |= unsigned(a[l] < b) << l;
  return bits;
#endif
}

inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }

TURGOR_HD inline float square_root(float a) { return std::sqrt(a); }
TURGOR_HD inline float larger(float a, float b) { return a > b ? a : b; }
TURGOR_HD inline float smaller(float a, float b) { return a < b ? a : b; }

/// Three-component vectors.
struct Lanes3 {
  Lanes x, y, z;
};
inline Lanes3 operator+(Lanes3 a, Lanes3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Lanes3 operator-(Lanes3 a, Lanes3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Lanes3 operator*(Lanes3 a, Lanes s) { return {a.x * s, a.y * s, a.z * s}; }
inline Lanes dot(Lanes3 a, Lanes3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace turgor
