// Vectors per vertex as structure of arrays, padded to whole batches of sixteen, with 3×3 symmetric matrices.
#pragma once

#include <type_traits>

#include "turgor/core/aligned.hpp"
#include "turgor/core/lanes.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::cloth {

/// `count` rounded up to whole batches of sixteen.
constexpr std::size_t padded(std::size_t count) {
  return (count + std::size_t(kLanes) - 1) / std::size_t(kLanes) * std::size_t(kLanes);
}

struct Vectors {
  aligned_vector<Real> x, y, z;

  Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, Vec3 a) { x[i] = a.x, y[i] = a.y, z[i] = a.z; }
  void add(std::size_t i, Vec3 a) { x[i] += a.x, y[i] += a.y, z[i] += a.z; }
  void resize(std::size_t count) { x.resize(count), y.resize(count), z.resize(count); }
  std::size_t size() const { return x.size(); }
};

inline Lanes3 load(const Vectors& a, std::size_t i) {
  return {load_lanes(&a.x[i]), load_lanes(&a.y[i]), load_lanes(&a.z[i])};
}
inline void store(Vectors& a, std::size_t i, Lanes3 b) {
  store_lanes(&a.x[i], b.x), store_lanes(&a.y[i], b.y), store_lanes(&a.z[i], b.z);
}
inline Lanes3 gather(const Vectors& a, const int* index) {
  return {gather_lanes(a.x.data(), index), gather_lanes(a.y.data(), index), gather_lanes(a.z.data(), index)};
}

/// Vector of sixteen vertices (T = Lanes) or of one (T = Real).
template <class T>
using Three = std::conditional_t<std::is_same_v<T, Lanes>, Lanes3, Vec3>;

/// Symmetric 3×3 matrix as its diagonal and xy, xz, yz.
template <class T>
struct Symmetric {
  Three<T> diagonal, off;
};
using LanesMatrix = Symmetric<Lanes>;

template <class T>
TURGOR_HD inline Three<T> operator*(const Symmetric<T>& m, Three<T> a) {
  return {m.diagonal.x * a.x + m.off.x * a.y + m.off.y * a.z,
          m.off.x * a.x + m.diagonal.y * a.y + m.off.z * a.z,
          m.off.y * a.x + m.off.z * a.y + m.diagonal.z * a.z};
}
/// Inverse of a positive definite matrix. It is scaled first, so that products of three small masses do not
/// underflow.
template <class T>
TURGOR_HD inline Symmetric<T> inverse(Symmetric<T> m) {
  const T scale = 1 / (m.diagonal.x + m.diagonal.y + m.diagonal.z);
  m.diagonal = m.diagonal * scale, m.off = m.off * scale;
  const auto [a, d, f] = m.diagonal;
  const auto [b, c, e] = m.off;
  const T m00 = d * f - e * e, m01 = c * e - b * f, m02 = b * e - d * c;
  const T s = scale / (a * m00 + b * m01 + c * m02);
  return {Three<T>{m00, a * f - c * c, a * d - b * b} * s, Three<T>{m01, m02, b * c - a * e} * s};
}

}  // namespace turgor::cloth
