// A triangle on its way through a step (or sixteen): its normals and its longest edge.
#pragma once

#include "turgor/models/cloth/device/sheet_view.hpp"

namespace turgor::cloth {

constexpr float kNarrow = 0.75f, kWide = 0.5f;  // cos² of 30° and 45°

template <class T>
struct MovingTriangle {
  Three<T> normal[3];  // of N(s) = Σ Bernstein polynomials of degree 2: all N(s) are in the cone of these
  T longest2;          // edge, of both ends of the way [m²]
};

template <class V>
TURGOR_HD inline V across(V a, V b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// By two of its sides, and how they change.
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

/// Below 0 where n lies in the cone around u that cos² says.
template <class V>
TURGOR_HD inline auto outside_of(const V& n, const V& u, float cos2) {
  const auto d = dot(n, u);
  const auto along = d > 0 ? d : d - d;
  return dot(u, u) * dot(n, n) * cos2 - along * along;
}

}  // namespace turgor::cloth
