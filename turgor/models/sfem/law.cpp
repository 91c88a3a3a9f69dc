#include "turgor/models/sfem/law.hpp"

#include <cmath>
#include <limits>

namespace turgor::sfem {

namespace {

using Tensor = std::array<double, 9>;

Tensor entries(const Mat3d& m) {
  Tensor t{};
  for (std::size_t k = 0; k < 9; k++) t[k] = m.column[int(k / 3)][int(k % 3)];
  return t;
}

Mat3d cofactor(const Mat3d& f) {
  const Vec3d a = f.column[0], b = f.column[1], c = f.column[2];
  return {{cross(b, c), cross(c, a), cross(a, b)}};
}

double squared_norm(const Mat3d& f) {
  double sum = 0;
  for (int axis = 0; axis < 3; axis++) sum += dot(f.column[axis], f.column[axis]);
  return sum;
}

/// Adds scale · ∂ cof F/∂F. Column J of cof F is the cross product of the next two columns of F.
void add_cofactor_slope(const Mat3d& f, double scale, std::array<double, 81>& tangent) {
  for (int column = 0; column < 3; column++) {
    const int next = (column + 1) % 3, last = (column + 2) % 3;
    for (int k = 0; k < 3; k++) {
      Vec3d unit;
      unit[k] = 1;
      const Vec3d by_next = cross(unit, f.column[last]), by_last = cross(f.column[next], unit);
      for (int i = 0; i < 3; i++) {
        const auto row = std::size_t(9 * (3 * column + i));
        tangent[row + std::size_t(3 * next + k)] += scale * by_next[i];
        tangent[row + std::size_t(3 * last + k)] += scale * by_last[i];
      }
    }
  }
}

}  // namespace

double law_energy(const Mat3d& f, const Moduli& m, const Law& law) {
  const double j = determinant(f);
  if (!(j > kLeastVolumeRatio)) return std::numeric_limits<double>::infinity();
  const double beyond = std::pow(j, -2.0 / 3) * squared_norm(f) - 3, exponent = law.stiffening * beyond;
  if (exponent > kLargestLawExponent) return std::numeric_limits<double>::infinity();
  const double isochoric = law.stiffening > 0 ? std::expm1(exponent) / law.stiffening : beyond;
  return 0.5 * m.shear * isochoric + 0.5 * m.bulk * (j - 1) * (j - 1);
}

LawStress law_stress(const Mat3d& f, const Moduli& m, const Law& law) {
  // invariants
  const double j = determinant(f), r = std::pow(j, -2.0 / 3), i1 = squared_norm(f);
  const double c = m.shear * std::exp(law.stiffening * (r * i1 - 3));
  const Tensor of_f = entries(f), g = entries(cofactor(f));
  // stress
  LawStress result;
  Tensor p{};
  for (std::size_t k = 0; k < 9; k++) {
    p[k] = r * of_f[k] - r * i1 / (3 * j) * g[k];
    result.stress[k] = c * p[k] + m.bulk * (j - 1) * g[k];
  }
  // tangent
  const double by_p = 2 * law.stiffening * c, mixed = -2.0 / 3 * c * r / j;
  const double by_g = 5.0 / 9 * c * r * i1 / (j * j) + m.bulk;
  for (std::size_t a = 0; a < 9; a++) {
    for (std::size_t b = 0; b < 9; b++)
      result.tangent[9 * a + b] =
          by_p * p[a] * p[b] + mixed * (of_f[a] * g[b] + g[a] * of_f[b]) + by_g * g[a] * g[b];
    result.tangent[10 * a] += c * r;
  }
  add_cofactor_slope(f, m.bulk * (j - 1) - c * r * i1 / (3 * j), result.tangent);
  return result;
}

double largest_strain(const Mat3d& f) {
  double sum = 0;
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const double e = 0.5 * (dot(f.column[a], f.column[b]) - (a == b ? 1 : 0));
      sum += e * e;
    }
  return std::sqrt(sum);
}

}  // namespace turgor::sfem
