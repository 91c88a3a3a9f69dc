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

/// Air velocity at vertices: mean wind plus Σ velocity · sin(2π (number·x + phase)) over the waves.
template <class T>
struct AirAt {
  ConstVectorsView x;
  VectorsView air;
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
    store<T>(air, i, (*this)(load<T>(x, i)));
  }
};

/// Wind load of a triangle on each of its corners in dt, a third of
///
///   ½ ρ A (C_n |u_n| u_n + C_t |u_t| u_t) dt
///
/// with u the air velocity relative to the triangle, u_n and u_t its normal and tangential components, A the
/// area, C_n = Air::pressure and C_t = Air::drag.
struct TriangleLoad {
  Vec3 impulse, normal;
  Real across = 0, along = 0;  // minus the derivatives by normal and tangential velocity

  /// Diagonal of minus the derivative by velocity, across n nᵀ + along (I − n nᵀ).
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

/// Triangles in the wind, and the arrays of their loads.
struct WindTriangles {
  const Int3* triangles;
  ConstVectorsView x, v, air;
  VectorsView impulse, diagonal, off_diagonal;  // as in AirLoad
  Real pressure, drag;

  TURGOR_HD TriangleLoad triangle_load(Int3 t) const {
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

/// Triangles around each vertex, ascending; also for padding vertices.
struct TrianglesAround {
  const int *begin, *item;
};

/// Load of a vertex from all its triangles, the sum of Sails::add. For one thread per vertex.
struct BlowVertex {
  WindTriangles wind_triangles;
  TrianglesAround around;

  TURGOR_HD void operator()(std::size_t v) const {
    Vec3 impulse, diagonal, off;
    for (int n = around.begin[v]; n < around.begin[v + 1]; n++) {
      const TriangleLoad load = wind_triangles.triangle_load(wind_triangles.triangles[around.item[n]]);
      impulse += load.impulse, diagonal += load.diagonal(), off += load.off_diagonal();
    }
    wind_triangles.impulse.set(v, impulse), wind_triangles.diagonal.set(v, diagonal),
        wind_triangles.off_diagonal.set(v, off);
  }
};

/// Wind in a step of dt on triangles at x with velocities v.
inline WindTriangles wind_triangles(const Air& air, double dt, const Int3* triangles, ConstVectorsView x,
                                    ConstVectorsView v, ConstVectorsView air_at, VectorsView impulse,
                                    VectorsView diagonal, VectorsView off) {
  const double quarter = 0.25 * air.density * dt / 3;  // ¼ ρ dt/3: multiplies twice the area
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
