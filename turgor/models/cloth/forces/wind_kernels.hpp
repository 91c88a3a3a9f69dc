// The air at the vertices of a sheet, and what it does to a triangle: a GPU and a CPU blow with these.
#pragma once

#include <span>

#include "turgor/models/cloth/device/sheet_view.hpp"
#include "turgor/models/cloth/forces/wind.hpp"

namespace turgor::cloth {

/// sin(2π a) to 1e-5: Taylor's polynomial on the half turn around the nearest zero.
template <class T>
TURGOR_HD inline T sine_of_turns(T a) {
  constexpr float kRound = 12582912;  // 1.5·2²³: adding it leaves no fraction
  a = a - ((a + kRound) - kRound);    // in [-½, ½]
  const T size = a < 0 ? -a : a;
  const T b = larger(smaller(a, 0.5f - size), size - 0.5f), b2 = b * b;  // sin(π − x) = sin x
  return b * (6.2831853f + b2 * (-41.341702f + b2 * (81.605249f + b2 * (-76.705860f + b2 * 42.058694f))));
}

/// The air's velocity at vertices.
template <class T>
struct AirAt {
  ConstVectorsView x;
  VectorsView air;
  Gusts gusts;
  bool is_steady;

  TURGOR_HD Three<T> operator()(Three<T> place) const {
    Three<T> u{all_of<T>(gusts.mean.x), all_of<T>(gusts.mean.y), all_of<T>(gusts.mean.z)};
    if (is_steady) return u;
    for (const auto& [number, velocity, phase] : gusts.waves) {
      const T s = sine_of_turns<T>(number.x * place.x + number.y * place.y + number.z * place.z + phase);
      u = u + Three<T>{velocity.x * s, velocity.y * s, velocity.z * s};
    }
    return u;
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    store<T>(air, i, (*this)(load<T>(x, i)));
  }
};

/// ½ ρ A (C_n |u_n| u_n + C_t |u_t| u_t) on a triangle, a third for each corner, times dt.
struct TriangleLoad {
  Vec3 impulse, normal;
  Real across = 0, along = 0;  // minus its derivatives by velocity: normal and tangential

  /// Of minus the derivative's matrix.
  TURGOR_HD Vec3 diagonal() const {
    const Real d = across - along;
    return {along + d * normal.x * normal.x, along + d * normal.y * normal.y,
            along + d * normal.z * normal.z};
  }
  TURGOR_HD Vec3 off_diagonal() const {
    const Real d = across - along;
    return {d * normal.x * normal.y, d * normal.x * normal.z, d * normal.y * normal.z};
  }
};

/// Triangles in the wind.
struct Sails {
  const Int3* triangles;
  ConstVectorsView x, v, air;
  VectorsView impulse, diagonal, off_diagonal;  // AirLoad
  Real pressure, drag;

  TURGOR_HD TriangleLoad load_of(Int3 t) const {
    const auto i = std::size_t(t.x), j = std::size_t(t.y), k = std::size_t(t.z);
    const Vec3 u = (air[i] + air[j] + air[k] - v[i] - v[j] - v[k]) * (Real(1) / 3);
    const Vec3 n = cross(x[j] - x[i], x[k] - x[i]);
    const Real twice_area = norm(n);
    if (!(twice_area > 0)) return {};
    const Vec3 normal = n / twice_area;
    const Real un = dot(u, normal), speed_n = std::abs(un);
    const Vec3 ut = u - normal * un;
    const Real speed_t = norm(ut), a = pressure * twice_area * speed_n, b = drag * twice_area * speed_t;
    return {normal * (a * un) + ut * b, normal, 2 * a, b};
  }
  TURGOR_HD void clear(std::size_t vertex) const {
    impulse.set(vertex, {}), diagonal.set(vertex, {}), off_diagonal.set(vertex, {});
  }
  TURGOR_HD void add(std::size_t vertex, const TriangleLoad& load) const {
    impulse.add(vertex, load.impulse);
    diagonal.add(vertex, load.diagonal()), off_diagonal.add(vertex, load.off_diagonal());
  }
};

/// Lists of the triangles around each vertex, ascending, also for what fills the last batch.
struct TrianglesAround {
  const int *begin, *item;
};

/// A vertex by all of its triangles: what Sails::add sums up, for a thread a vertex.
struct BlowVertex {
  Sails sails;
  TrianglesAround around;

  TURGOR_HD void operator()(std::size_t v) const {
    Vec3 impulse, diagonal, off;
    for (int n = around.begin[v]; n < around.begin[v + 1]; n++) {
      const TriangleLoad load = sails.load_of(sails.triangles[around.item[n]]);
      impulse += load.impulse, diagonal += load.diagonal(), off += load.off_diagonal();
    }
    sails.impulse.set(v, impulse), sails.diagonal.set(v, diagonal), sails.off_diagonal.set(v, off);
  }
};

/// What the air does in dt, of triangles at x with the velocities v.
inline Sails sails(const Air& air, double dt, const Int3* triangles, ConstVectorsView x, ConstVectorsView v,
                   ConstVectorsView air_at, VectorsView impulse, VectorsView diagonal, VectorsView off) {
  const double quarter = 0.25 * air.density * dt / 3;  // of twice the area
  return {triangles,
          x,
          v,
          air_at,
          impulse,
          diagonal,
          off,
          Real(quarter * air.pressure),
          Real(quarter * air.drag)};
}
inline bool is_steady(const Air& air) { return air.gusts == 0 || air.velocity == Vec3d{}; }

}  // namespace turgor::cloth
