// A patch of an elastic half space z < 0: points on a square grid and their displacements under a unit force
// spread over one cell. [Boussinesq, Cerruti; Love 1929 for the normal displacement under a rectangle]
#pragma once

#include <cmath>
#include <numbers>

#include "turgor/models/sfem/patch.hpp"

namespace turgor {

struct HalfSpace {
  int side = 9;           // points along each axis
  double spacing = 1e-3;  // [m]
  double young = 1e4;     // [Pa]
  double poisson = 0.5;
};

/// ∫∫ 1/r over a square cell whose center is at distance (x, y), per area [1/m].
inline double mean_inverse_distance(double x, double y, double h) {
  const auto corner = [](double a, double b) {
    const double r = std::hypot(a, b);
    const auto term = [r](double p, double q) { return p == 0 ? 0.0 : p * std::log(q + r); };
    return term(a, b) + term(b, a);
  };
  const double x0 = x - h / 2, x1 = x + h / 2, y0 = y - h / 2, y1 = y + h / 2;
  return (corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)) / (h * h);
}

/// Displacement at distance (x, y) of a unit force along each axis; column j belongs to a force along j.
inline Mat3d half_space_response(const HalfSpace& s, double x, double y) {
  const double nu = s.poisson, scale = (1 + nu) / (std::numbers::pi * s.young), r2 = x * x + y * y;
  const double inverse = mean_inverse_distance(x, y, s.spacing);
  if (r2 == 0)
    return {{{scale * (1 - nu / 2) * inverse, 0, 0},
             {0, scale * (1 - nu / 2) * inverse, 0},
             {0, 0, scale * (1 - nu) * inverse}}};
  const double shear = scale * nu * inverse / r2, tilt = scale * (1 - 2 * nu) / 2 / r2;
  return {{{scale * (1 - nu) * inverse + shear * x * x, shear * x * y, -tilt * x},
           {shear * x * y, scale * (1 - nu) * inverse + shear * y * y, -tilt * y},
           {tilt * x, tilt * y, scale * (1 - nu) * inverse}}};
}

inline sfem::Patch half_space_patch(const HalfSpace& s, Vec3d corner_shift = {}) {
  sfem::Patch patch;
  const double half = s.spacing * (s.side - 1) / 2;
  for (int j = 0; j < s.side; j++)
    for (int i = 0; i < s.side; i++) {
      sfem::PatchPoint point;
      point.x = Vec3d{i * s.spacing - half, j * s.spacing - half, 0} + corner_shift;
      const auto key = [&](double v) { return std::uint64_t(std::llround(v / s.spacing * 16) + 100000); };
      point.key = key(point.x.x) << 32 | key(point.x.y);
      point.coarse[0] = int(patch.points.size());
      point.weight[0] = 1;
      point.supports = 1;
      patch.coarse.push_back(int(patch.points.size()));
      patch.points.push_back(point);
    }
  for (int j = 0; j + 1 < s.side; j++)
    for (int i = 0; i + 1 < s.side; i++) {
      const int a = j * s.side + i, b = a + 1, c = a + s.side + 1, d = a + s.side;
      patch.triangles.push_back({a, b, c});
      patch.triangles.push_back({a, c, d});
    }
  const std::size_t n = patch.points.size();
  patch.compliance.resize(9 * n * n);
  for (std::size_t q = 0; q < n; q++)
    for (std::size_t p = 0; p < n; p++) {
      const Vec3d d = patch.points[p].x - patch.points[q].x;
      const Mat3d response = half_space_response(s, d.x, d.y);
      for (int axis = 0; axis < 3; axis++)
        for (int row = 0; row < 3; row++)
          patch.compliance[(3 * q + std::size_t(axis)) * 3 * n + 3 * p + std::size_t(row)] =
              response.column[axis][row];
    }
  return patch;
}

}  // namespace turgor
