// Side tensions of one triangle (membrane.hpp). T selects sixteen triangles at once, one per GPU thread, or
// double precision.
#pragma once

#include <cmath>

#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/wind_kernels.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth::tension {

using turgor::larger;
using turgor::square_root;
inline double square_root(double a) { return std::sqrt(a); }
inline double larger(double a, double b) { return a > b ? a : b; }
inline double all_of(double, double value) { return value; }
TURGOR_HD inline Real all_of(Real, double value) { return Real(value); }
inline Lanes all_of(Lanes, double value) { return all_lanes(float(value)); }

/// Symmetric 2×2 matrix along warp and weft.
template <class T>
struct Plane {
  T warp, weft, both;
};

/// Gradients of the shape functions of the second and third corner [1/m].
template <class T>
struct Slopes {
  T second[2], third[2];
};

/// C = FᵀF with F = Σ_i x_i ∇N_iᵀ, from the sides p and q to the second and third corner. F comes first: in a
/// thin triangle its large terms cancel, and in products of two gradients they would cancel twice.
template <class T, class V>
TURGOR_HD inline Plane<T> squared_stretch(const Slopes<T>& g, V p, V q) {
  const V warp = p * g.second[0] + q * g.third[0], weft = p * g.second[1] + q * g.third[1];
  return {dot(warp, warp), dot(weft, weft), dot(warp, weft)};
}

/// U = √C by Cayley and Hamilton: U = (C + √det C · I)/√(tr C + 2 √det C). The determinant is bounded below,
/// so degenerate triangles give finite values.
template <class T>
TURGOR_HD inline Plane<T> stretch(const Plane<T>& c) {
  const T least = all_of(c.warp, 1e-6);
  const T root = square_root(larger(c.warp * c.weft - c.both * c.both, least));
  const T scale = 1 / square_root(c.warp + c.weft + root + root);
  return {(c.warp + root) * scale, (c.weft + root) * scale, c.both * scale};
}

template <class T>
struct Stress {
  Plane<T> conjugate;  // symmetric S with (S U + U S)/2 = D (U − 1), conjugate to FᵀF/2 [N/m]
  T energy;            // per rest area [J/m²]
};

/// Stress S and energy density ½ (U − 1) : D (U − 1) from the stretch U.
template <class T>
TURGOR_HD inline Stress<T> stress(const MembraneLaw& m, const Plane<T>& u) {
  const T one = all_of(u.warp, 1), e1 = u.warp - one, e2 = u.weft - one;
  const T t1 = e1 * T(all_of(one, m.warp)) + e2 * T(all_of(one, m.both)),
          t2 = e2 * T(all_of(one, m.weft)) + e1 * T(all_of(one, m.both)),
          t12 = u.both * T(all_of(one, 2 * double(m.shear)));
  const T a = 1 / u.warp, c = 1 / u.weft, b = u.both;
  const T sum = (u.warp + u.weft) * (one - b * b * a * c);
  const T s12 = (t12 + t12 - b * (t1 * a + t2 * c)) / sum;
  return {{(t1 - s12 * b) * a, (t2 - s12 * b) * c, s12},
          (t1 * e1 + t2 * e2 + (t12 + t12) * b) * T(all_of(one, 0.5))};
}

template <class T>
struct Sides {
  T side[3];  // tensions, force over length [N/m]
  T energy;   // [J]
};

/// Tensions of the sides: τ_ij = −A ∇N_iᵀ S ∇N_j. The force on i along side i j is τ_ij (x_j − x_i). A is the
/// rest area, recovered from the gradients; those of slivers are 0, and so is their force.
template <class T, class V>
TURGOR_HD inline Sides<T> tensions(const MembraneLaw& m, const Slopes<T>& g, V p, V q) {
  const Stress<T> s = stress(m, stretch(squared_stretch(g, p, q)));
  const T twice = g.second[0] * g.third[1] - g.second[1] * g.third[0], size = larger(twice, -twice);
  const T area = size > 0 ? all_of(twice, 0.5) / size : all_of(twice, 0);
  const T first[2] = {-g.second[0] - g.third[0], -g.second[1] - g.third[1]};
  const auto between = [&](const T(&a)[2], const T(&b)[2]) {
    return -area * (a[0] * (s.conjugate.warp * b[0] + s.conjugate.both * b[1]) +
                    a[1] * (s.conjugate.both * b[0] + s.conjugate.weft * b[1]));
  };
  return {{between(first, g.second), between(g.second, g.third), between(g.third, first)}, area * s.energy};
}

}  // namespace turgor::cloth::tension

namespace turgor::cloth {

/// Triangles of a sheet; null for springs.
struct MembraneView {
  MembraneLaw law;
  const Int3* triangles;
  const Real *second[2], *third[2];
  const std::array<std::uint8_t, 6>* slot;
  const std::array<std::uint16_t, 6>* wide_slot;  // instead of `slot`; else null

  /// Entry of side n / 2 of a triangle in the rows of vertex i, its first or second end.
  TURGOR_HD std::size_t entry(const SheetView& sheet, std::size_t i, int triangle, int n) const {
    const auto k = std::size_t(n);
    const int at = wide_slot != nullptr ? int(wide_slot[triangle][k]) : int(slot[triangle][k]);
    return entry_of<Real>(sheet.rows.begin(i) + at, i);
  }
};
inline MembraneView view(const Membrane& m, const std::vector<Int3>& triangles) {
  return {m.law,
          triangles.data(),
          {m.second[0].data(), m.second[1].data()},
          {m.third[0].data(), m.third[1].data()},
          m.slot.data(),
          m.wide_slot.empty() ? nullptr : m.wide_slot.data()};
}

/// Tensions around a vertex from all its triangles, like find_tensions. For one thread per vertex.
struct TensionsAround {
  SheetView sheet;
  MembraneView membrane;
  TrianglesAround around;

  TURGOR_HD void operator()(std::size_t v) const {
    // cleared entries
    for (int slot = sheet.rows.begin(v); slot < sheet.rows.end(v); slot++)
      sheet.across[entry_of<Real>(slot, v)] = 0;
    // tensions of incident triangles
    for (int n = around.begin[v]; n < around.begin[v + 1]; n++) {
      const int t = around.item[n];
      const Int3 corner = membrane.triangles[t];
      const Vec3 a = sheet.x[std::size_t(corner.x)];
      const tension::Slopes<Real> g{{membrane.second[0][t], membrane.second[1][t]},
                                    {membrane.third[0][t], membrane.third[1][t]}};
      const tension::Sides<Real> found =
          tensions(membrane.law, g, sheet.x[std::size_t(corner.y)] - a, sheet.x[std::size_t(corner.z)] - a);
      for (int side = 0; side < 3; side++)
        for (int end = 0; end < 2; end++)
          if (std::size_t(corner[(side + end) % 3]) == v)
            sheet.across[membrane.entry(sheet, v, t, 2 * side + end)] += found.side[side];
    }
  }
};

}  // namespace turgor::cloth
