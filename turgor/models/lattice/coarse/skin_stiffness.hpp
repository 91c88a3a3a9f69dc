// Stiffness of skin as in the CT, for the coarse operator.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"

namespace turgor::lattice {

constexpr Mat3d kNothing{{Vec3d{}, Vec3d{}, Vec3d{}}};
inline void add_outer(Mat3d& m, Vec3d a, Vec3d b, double by) {
  for (int j = 0; j < 3; j++) m.column[std::size_t(j)] = m.column[std::size_t(j)] + a * (b[j] * by);
}
inline void add_isotropic(Mat3d& m, double by) {
  for (int j = 0; j < 3; j++) m.column[std::size_t(j)][j] += by;
}

/// Stiffness of pairs of corners of a triangle as in the CT, positive semidefinite like the Hessians of VBD
/// (add_skin_fiber, add_skin_area).
struct SkinStiffness {
  const Model& model;
  FiberLaw law;
  SkinTangent tangent;  // exponential law

  explicit SkinStiffness(const Model& m) : model(m), law(fiber_law(m.params.skin)) {
    if (m.params.skin.law == SkinLaw::kExponential)
      tangent = skin_tangent(m.params.skin, stretch_of_tension(m.params.skin).value_or(SkinStretch{}));
  }

  /// Stiffness of all pairs 3 a + b of corners.
  std::array<Mat3d, 9> pairs(const SkinTriangle& t) const {
    if (model.params.skin.law == SkinLaw::kFiber) return fiber_pairs(t);
    std::array<Mat3d, 9> k{};
    for (int n = 0; n < 9; n++)
      k[std::size_t(n)] = model.params.skin.law == SkinLaw::kExponential ? tangent_stiffness(t, n / 3, n % 3)
                                                                         : area_stiffness(t, n / 3, n % 3);
    return k;
  }
  std::array<Mat3d, 9> fiber_pairs(const SkinTriangle& t) const {
    const Vec3d e1(t.edge1), e2(t.edge2);
    const Vec3d f = e1 * double(t.along[1]) + e2 * double(t.along[2]),
                g = e1 * double(t.across[1]) + e2 * double(t.across[2]);
    // stiffness of both fibers and of shear for unit weights
    Mat3d along = kNothing, across = kNothing;
    add_fiber(along, f, 1, double(law.rest_along), t.area);
    add_fiber(across, g, 1, double(law.rest_across), t.area);
    const double shear = double(law.shear) * double(t.area);
    std::array<Mat3d, 9> k{};
    for (std::size_t n = 0; n < 9; n++) {
      const int a = int(n) / 3, b = int(n) % 3;
      const double by_along = double(t.along[a]) * double(t.along[b]),
                   by_across = double(t.across[a]) * double(t.across[b]);
      for (std::size_t j = 0; j < 3; j++)
        k[n].column[j] = along.column[j] * by_along + across.column[j] * by_across;
      add_outer(k[n], f * double(t.across[a]) + g * double(t.along[a]),
                f * double(t.across[b]) + g * double(t.along[b]), shear);
    }
    return k;
  }
  /// Strains along e and across g, and their tension: the tangent of the law at the tension of the CT.
  Mat3d tangent_stiffness(const SkinTriangle& t, int a, int b) const {
    const Vec3d e1(t.edge1), e2(t.edge2);
    const Vec3d e = e1 * double(t.along[1]) + e2 * double(t.along[2]),
                g = e1 * double(t.across[1]) + e2 * double(t.across[2]);
    const double area = double(t.area), xa = double(t.along[a]), xb = double(t.along[b]),
                 ya = double(t.across[a]), yb = double(t.across[b]);
    Mat3d k = kNothing;
    add_outer(k, e, e, area * tangent.along * xa * xb);
    add_outer(k, g, g, area * tangent.across * ya * yb);
    add_outer(k, e, g, area * tangent.coupling * xa * yb);
    add_outer(k, g, e, area * tangent.coupling * ya * xb);
    add_outer(k, e * ya + g * xa, e * yb + g * xb, area * tangent.shear);
    add_isotropic(k, area * (tangent.tension_along * xa * xb + tangent.tension_across * ya * yb));
    return k;
  }
  /// Derivatives of the shape functions of a cell's corners along both fibers of a patch, at its points.
  struct PatchSlopes {
    double along[kPatchPoints][kCellCorners], across[kPatchPoints][kCellCorners];
  };
  PatchSlopes slopes(const SkinPatch& p) const {
    const Vec3 slope = solid_law(model.anatomy.lattice.spacing, 0).slope;
    PatchSlopes out;
    for (int n = 0; n < kPatchPoints; n++)
      for (int a = 0; a < kCellCorners; a++) {
        const Vec3d gradient(shape_gradient(a, slope, patch_point(p, n)));
        out.along[n][a] = dot(gradient, Vec3d(p.along)), out.across[n][a] = dot(gradient, Vec3d(p.across));
      }
    return out;
  }
  /// The same for corners a and b of the cell of a patch.
  Mat3d operator()(const SkinPatch& p, const PatchSlopes& at, int a, int b) const {
    const double area = double(p.area) / kPatchPoints;
    const Vec3d f(p.along), g(p.across);
    Mat3d k = kNothing;
    for (int n = 0; n < kPatchPoints; n++) {
      const double fa = at.along[n][a], fb = at.along[n][b], ga = at.across[n][a], gb = at.across[n][b];
      add_fiber(k, f, fa * fb, double(law.rest_along), area);
      add_fiber(k, g, ga * gb, double(law.rest_across), area);
      add_outer(k, f * ga + g * fa, f * gb + g * fb, double(law.shear) * area);
    }
    return k;
  }
  void add_fiber(Mat3d& k, Vec3d g, double share, double rest, double area) const {
    TURGOR_CHECK(norm(g) > 0 && rest > 0, "a fiber has a length");
    const double length = norm(g), strain = std::max(0.0, length - rest);
    const double stiffness =
        double(law.stiffness) * area * share * (1 + double(law.amplification) * strain / rest);
    const double lateral = stiffness * strain / length;
    add_outer(k, g, g, (stiffness - lateral) / (length * length));
    add_isotropic(k, lateral);
  }
  Mat3d area_stiffness(const SkinTriangle& t, int a, int b) const {
    TURGOR_CHECK(t.area > 0, "a skin triangle has an area in the CT");
    const Vec3d position[3] = {{}, Vec3d(t.edge1), Vec3d(t.edge2)};
    const Vec3d n = cross(position[1], position[2]), u = n * (1 / norm(n));
    const double ratio = double(rest_area_ratio(model.params.skin)), growth = 1 / ratio - 1;
    const double stiffness =
        model.params.skin.stiffness / (ratio * t.area) * (1 + model.params.skin.amplification * growth);
    const auto opposite = [&](int c) { return position[(c + 1) % 3] - position[(c + 2) % 3]; };
    const Vec3d ga = cross(opposite(a), u) * 0.5, gb = cross(opposite(b), u) * 0.5;
    Mat3d k = kNothing;
    add_outer(k, ga, gb, stiffness);
    add_outer(k, u, u, stiffness * (1 - ratio) * t.area * dot(opposite(a), opposite(b)) / (2 * norm(n)));
    return k;
  }
};

}  // namespace turgor::lattice
