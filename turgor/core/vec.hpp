// Small vectors and matrices: Vec3 in the simulation's precision, Vec3d for stored positions, Int3 for
// indices. It holds only what the engine uses; large linear algebra is elsewhere.
#pragma once

#include <cmath>

#include "turgor/core/config.hpp"

namespace turgor {

template <class T>
struct Vec {
  T x{}, y{}, z{};

  // Explicit, because nvcc otherwise takes Vec3(Int3) for aggregate initialization.
  Vec() = default;
  TURGOR_HD constexpr Vec(T a, T b, T c) : x(a), y(b), z(c) {}
  template <class U>
  TURGOR_HD constexpr explicit Vec(Vec<U> v) : x(T(v.x)), y(T(v.y)), z(T(v.z)) {}

  TURGOR_HD constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  TURGOR_HD constexpr T operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  TURGOR_HD constexpr Vec& operator+=(Vec b) { return *this = {x + b.x, y + b.y, z + b.z}; }
  TURGOR_HD constexpr Vec& operator-=(Vec b) { return *this = {x - b.x, y - b.y, z - b.z}; }
  TURGOR_HD constexpr Vec& operator*=(T s) { return *this = {x * s, y * s, z * s}; }
  friend constexpr bool operator==(const Vec&, const Vec&) = default;
};

using Vec3 = Vec<Real>;
using Vec3d = Vec<double>;
using Int3 = Vec<int>;

template <class T>
TURGOR_HD constexpr Vec<T> operator+(Vec<T> a, Vec<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
TURGOR_HD constexpr Vec<T> operator-(Vec<T> a, Vec<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
TURGOR_HD constexpr Vec<T> operator-(Vec<T> a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
TURGOR_HD constexpr Vec<T> operator*(Vec<T> a, decltype(T{}) s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
TURGOR_HD constexpr Vec<T> operator*(decltype(T{}) s, Vec<T> a) {
  return a * s;
}
template <class T>
TURGOR_HD constexpr Vec<T> operator/(Vec<T> a, decltype(T{}) s) {
  return {a.x / s, a.y / s, a.z / s};
}
template <class T>
TURGOR_HD constexpr T dot(Vec<T> a, Vec<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
TURGOR_HD constexpr Vec<T> cross(Vec<T> a, Vec<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// True if every component is finite. For the host only.
template <class T>
bool is_finite(const Vec<T>& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
template <class T>
TURGOR_HD T norm(Vec<T> a) {
  return std::sqrt(dot(a, a));
}
/// a / |a|; the zero vector stays zero.
template <class T>
TURGOR_HD Vec<T> normalized(Vec<T> a) {
  const T length = norm(a);
  return length > 0 ? a / length : a;
}
/// Componentwise product, minimum and maximum.
template <class T>
TURGOR_HD constexpr Vec<T> hadamard(Vec<T> a, Vec<T> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <class T>
TURGOR_HD constexpr Vec<T> min(Vec<T> a, Vec<T> b) {
  return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z};
}
template <class T>
TURGOR_HD constexpr Vec<T> max(Vec<T> a, Vec<T> b) {
  return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}

/// 3×3 matrix by columns.
struct Mat3d {
  Vec3d column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  friend constexpr bool operator==(const Mat3d&, const Mat3d&) = default;
};

constexpr Vec3d operator*(const Mat3d& m, Vec3d v) {
  return m.column[0] * v.x + m.column[1] * v.y + m.column[2] * v.z;
}
constexpr Mat3d operator*(const Mat3d& a, const Mat3d& b) {
  return {{a * b.column[0], a * b.column[1], a * b.column[2]}};
}
constexpr Mat3d transposed(const Mat3d& m) {
  const auto& [a, b, c] = m.column;
  return {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}};
}
constexpr double determinant(const Mat3d& m) { return dot(m.column[0], cross(m.column[1], m.column[2])); }
/// Inverse; the determinant must not be zero.
constexpr Mat3d inverse(const Mat3d& m) {
  const auto& [a, b, c] = m.column;
  const double d = determinant(m);
  return transposed({{cross(b, c) / d, cross(c, a) / d, cross(a, b) / d}});
}

}  // namespace turgor
