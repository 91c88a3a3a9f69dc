// Kernels of the wind for host and device: air velocity at vertices, load on a triangle.
#pragma once

#include <span>

#include "turgor/models/cloth/forces/wind.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

/// sin(2π a) to 1e-5: Taylor polynomial on the half turn around the nearest zero.
template <class T>
TURGOR_HD inline T sine_of_turns(T a) {
  constexpr float kRound = 12582912;  // 1.5·2²³: adding it rounds to an integer
  a = a - ((a + kRound) - kRound);    // in [-½, ½]
  const T size = a < 0 ? -a : a;
  const T b = larger(smaller(a, 0.5f - size), size - 0.5f), b2 = b * b;  // sin(π − x) = sin x
  return b * (6.2831853f + b2 * (-41.341702f + b2 * (81.605249f + b2 * (-76.705860f + b2 * 42.058694f))));
}

/// Air velocity at a position: mean wind plus Σ velocity · sin(2π (number·x + phase)) over the waves. At
/// vertices it is relative to them.
template <class T>
struct AirAt {
  ConstVectorsView x, v;
  VectorsView relative_air;
  Gusts gusts;
  bool is_steady;

  TURGOR_HD Three<T> operator()(Three<T> position) const {
    Three<T> u{all_of<T>(gusts.mean.x), all_of<T>(gusts.mean.y), all_of<T>(gusts.mean.z)};
    if (is_steady) return u;
    for (const auto& [number, velocity, phase] : gusts.waves) {
      const T s =
          sine_of_turns<T>(number.x * position.x + number.y * position.y + number.z * position.z + phase);
      u = u + Three<T>{velocity.x * s, velocity.y * s, velocity.z * s};
    }
    return u;
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t i = n * kAtOnce<T>;
    store<T>(relative_air, i, (*this)(load<T>(x, i)) - load<T>(v, i));
  }
};

/// Wind load of a triangle (or of sixteen) on each of its corners in dt, a third of
///
///   ½ ρ A (C_n |u_n| u_n + C_t |u_t| u_t) dt
///
/// with u the air velocity relative to the triangle, u_n and u_t its normal and tangential components, A the
/// area, C_n = Air::pressure and C_t = Air::drag.
template <class T>
struct TriangleLoad {
  Three<T> impulse, normal;
  T across, along;  // minus the derivatives by normal and tangential velocity

  /// Diagonal of minus the derivative by velocity, across n nᵀ + along (I − n nᵀ).
  TURGOR_HD Three<T> diagonal() const {
    const T d = across - along;
    return {along + d * normal.x * normal.x, along + d * normal.y * normal.y,
            along + d * normal.z * normal.z};
  }
  TURGOR_HD Three<T> off_diagonal() const {
    const T d = across - along;
    return {d * normal.x * normal.y, d * normal.x * normal.z, d * normal.y * normal.z};
  }
};

/// Load of a triangle with sides e and f that the air meets with the relative velocity u. A triangle without
/// area has none. `pressure` and `drag` are those of WindTriangles.
template <class T>
TURGOR_HD inline TriangleLoad<T> triangle_load(Three<T> e, Three<T> f, Three<T> u, Real pressure, Real drag) {
  const Three<T> n{e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x};
  const T length = square_root(dot(n, n)), zero = all_of<T>(0);
  const T twice_area = length > 0 ? length : zero;
  const T inverse = length > 0 ? 1 / length : zero;
  const Three<T> normal = n * inverse;
  const T un = dot(u, normal), speed_n = un < 0 ? -un : un;
  const Three<T> ut = u - normal * un;
  const T speed_t = square_root(dot(ut, ut));
  const T a = twice_area * speed_n * pressure, b = twice_area * speed_t * drag;
  return {normal * (a * un) + ut * b, normal, a * 2, b};
}

/// Triangles in the wind, and the arrays of their loads.
struct WindTriangles {
  const Int3* triangles;
  ConstVectorsView x, relative_air;             // positions; air velocity relative to the vertices [m] [m/s]
  VectorsView impulse, diagonal, off_diagonal;  // as in AirLoad
  Real pressure, drag;

  /// Load of the triangle with these corners (T = Real), or of sixteen (T = Lanes, arrays of corners).
  template <class T, class Corner>
  TURGOR_HD TriangleLoad<T> load(Corner i, Corner j, Corner k) const {
    const Three<T> xi = at(x, i);
    const Three<T> u =
        (at(relative_air, i) + at(relative_air, j) + at(relative_air, k)) * all_of<T>(Real(1) / 3);
    return triangle_load<T>(at(x, j) - xi, at(x, k) - xi, u, pressure, drag);
  }
  TURGOR_HD static Vec3 at(const ConstVectorsView& a, int i) { return a[std::size_t(i)]; }
  static Lanes3 at(const ConstVectorsView& a, const int* index) { return gather(a, index); }
};

/// Triangles around each vertex, ascending; also for padding vertices.
struct TrianglesAround {
  const int *begin, *item;
};

/// Load of a vertex from all its triangles, ascending. For one thread per vertex.
struct BlowVertex {
  WindTriangles wind_triangles;
  TrianglesAround around;

  TURGOR_HD void operator()(std::size_t v) const {
    Vec3 impulse, diagonal, off;
    for (int n = around.begin[v]; n < around.begin[v + 1]; n++) {
      const auto [i, j, k] = wind_triangles.triangles[around.item[n]];
      const TriangleLoad<Real> load = wind_triangles.load<Real>(i, j, k);
      impulse += load.impulse, diagonal += load.diagonal(), off += load.off_diagonal();
    }
    wind_triangles.impulse.set(v, impulse), wind_triangles.diagonal.set(v, diagonal),
        wind_triangles.off_diagonal.set(v, off);
  }
};

/// Wind in a step of dt on triangles at x in the air of AirAt.
inline WindTriangles wind_triangles(const Air& air, double dt, const Int3* triangles, ConstVectorsView x,
                                    ConstVectorsView relative_air, VectorsView impulse, VectorsView diagonal,
                                    VectorsView off) {
  const double quarter = 0.25 * air.density * dt / 3;  // ¼ ρ dt/3: multiplies twice the area
  return {triangles,
          x,
          relative_air,
          impulse,
          diagonal,
          off,
          Real(quarter * air.pressure),
          Real(quarter * air.drag)};
}
inline bool is_steady(const Air& air) { return air.gusts == 0 || air.velocity == Vec3d{}; }

}  // namespace turgor::cloth
