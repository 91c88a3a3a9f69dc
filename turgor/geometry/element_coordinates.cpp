#include "turgor/geometry/element_coordinates.hpp"

#include <cmath>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

std::array<double, 4> tet_coordinates(std::span<const Vec3d, 4> x, Vec3d p) {
  const double whole = orientation(x[0], x[1], x[2], x[3]);
  const double b = orientation(x[0], p, x[2], x[3]) / whole, c = orientation(x[0], x[1], p, x[3]) / whole,
               d = orientation(x[0], x[1], x[2], p) / whole;
  return {1 - b - c - d, b, c, d};
}

void trilinear(Vec3d s, std::span<double, 8> weight, std::array<Vec3d, 8>& gradient) {
  constexpr int kCorner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (std::size_t c = 0; c < 8; c++) {
    double f[3], slope[3];
    for (int axis = 0; axis < 3; axis++) {
      f[axis] = kCorner[c][axis] ? s[axis] : 1 - s[axis];
      slope[axis] = kCorner[c][axis] ? 1 : -1;
    }
    weight[c] = f[0] * f[1] * f[2];
    gradient[c] = {slope[0] * f[1] * f[2], f[0] * slope[1] * f[2], f[0] * f[1] * slope[2]};
  }
}

Vec3d hex_coordinates(std::span<const Vec3d, 8> x, Vec3d p) {
  constexpr Vec3d kLow{-1, -1, -1}, kHigh{2, 2, 2};
  Vec3d s{0.5, 0.5, 0.5};
  std::array<double, 8> weight{};
  std::array<Vec3d, 8> gradient{};
  for (int pass = 0; pass < 20; pass++) {
    trilinear(s, weight, gradient);
    Vec3d at;
    Mat3d map{{{}, {}, {}}};
    for (std::size_t c = 0; c < 8; c++) {
      at += x[c] * weight[c];
      for (int axis = 0; axis < 3; axis++) map.column[axis] += x[c] * gradient[c][axis];
    }
    if (!(std::abs(determinant(map)) > 0)) break;
    const Vec3d step = inverse(map) * (p - at);
    s = min(max(s + step, kLow), kHigh);
    if (norm(step) < 1e-14) break;
  }
  return s;
}

}  // namespace turgor
