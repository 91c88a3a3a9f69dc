// Normals and longest edge of a triangle that moves linearly in a step (or of sixteen). CCD skips regions
// whose normals stay in a cone.
#pragma once

#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

constexpr float kNarrow = 0.75f, kWide = 0.5f;  // cos² of 30° and 45°

/// Normals of a triangle that moves linearly:
///
///   N(s) = N₀ B₀(s) + N₁ B₁(s) + N₂ B₂(s)
///
/// with Bernstein polynomials B of degree 2, so N(s) stays in the cone of N₀, N₁, N₂.
template <class T>
struct MovingTriangle {
  Three<T> normal[3];  // N₀, N₁, N₂ [m²]
  T longest2;          // longest edge at the beginning or the end, squared [m²]
};

template <class V>
TURGOR_HD inline V across(V a, V b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Moving triangle from two sides e and their changes f.
template <class T>
TURGOR_HD inline MovingTriangle<T> moving_triangle(Three<T> e1, Three<T> e2, Three<T> f1, Three<T> f2) {
  const auto longest_of = [](const Three<T>& a, const Three<T>& b) {
    const Three<T> c = b - a;
    return larger(dot(a, a), larger(dot(b, b), dot(c, c)));
  };
  const Three<T> n0 = across(e1, e2), change = across(e1, f2) + across(f1, e2);
  return {{n0, n0 + change * all_of<T>(0.5f), n0 + change + across(f1, f2)},
          larger(longest_of(e1, e2), longest_of(e1 + f1, e2 + f2))};
}

/// Negative if n is inside the cone around u with the given cos².
template <class V>
TURGOR_HD inline auto outside_of(const V& n, const V& u, float cos2) {
  const auto d = dot(n, u);
  const auto along = d > 0 ? d : d - d;
  return dot(u, u) * dot(n, n) * cos2 - along * along;
}

}  // namespace turgor::cloth
