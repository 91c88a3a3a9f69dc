#include "turgor/contact/needle_beam.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

constexpr std::size_t kBand = 4;

double sum_over(const BeamVector& of_nodes, const BeamShape& at, const std::array<double, 4>& weight) {
  double sum = 0;
  for (int k = 0; k < 4 && at.first + k < kBeamUnknowns; k++)
    sum += weight[std::size_t(k)] * of_nodes[std::size_t(at.first + k)];
  return sum;
}

double energy_in_plane(const BeamMatrix& stiffness, const BeamVector& u) {
  double energy = 0;
  for (std::size_t i = 0; i < kBeamUnknowns; i++) {
    energy += 0.5 * stiffness.band[i][0] * u[i] * u[i];
    for (std::size_t k = 1; k <= std::min(i, kBand - 1); k++)
      energy += stiffness.band[i][k] * u[i] * u[i - k];
  }
  return energy;
}

}  // namespace

// Stiffness of an element of length h: EI/h³ times the matrix of its deflections and of h times its slopes.
BeamMatrix beam_stiffness(const Needle& needle) {
  TURGOR_CHECK(needle.bending > 0 && needle.length > 0, "a beam has a bending stiffness and a length");
  const double h = needle.length / kBeamElements, scale = needle.bending / (h * h * h);
  const double element[4][4] = {{12, 6 * h, -12, 6 * h},
                                {6 * h, 4 * h * h, -6 * h, 2 * h * h},
                                {-12, -6 * h, 12, -6 * h},
                                {6 * h, 2 * h * h, -6 * h, 4 * h * h}};
  BeamMatrix matrix;
  for (std::size_t e = 0; e < kBeamElements; e++)
    for (std::size_t i = 0; i < 4; i++)
      for (std::size_t j = 0; j <= i; j++)
        if (2 * e + i < kBeamUnknowns) matrix.band[2 * e + i][i - j] += scale * element[i][j];
  return matrix;
}

void factorize(BeamMatrix& matrix) {
  for (std::size_t i = 0; i < kBeamUnknowns; i++) {
    // row i of L, from the rows before it
    for (std::size_t k = std::min(i, kBand - 1); k > 0; k--) {
      const std::size_t j = i - k;
      double sum = matrix.band[i][k];
      for (std::size_t m = k + 1; m <= std::min(i, kBand - 1); m++)
        sum -= matrix.band[i][m] * matrix.band[j][m - k];
      matrix.band[i][k] = sum * matrix.band[j][0];
    }
    // reciprocal of its diagonal
    double diagonal = matrix.band[i][0];
    for (std::size_t k = 1; k <= std::min(i, kBand - 1); k++)
      diagonal -= matrix.band[i][k] * matrix.band[i][k];
    TURGOR_CHECK(diagonal > 0, "the matrix of a beam is positive definite");
    matrix.band[i][0] = 1 / std::sqrt(diagonal);
  }
}

// Both planes at once: each alone waits for its last entry.
void solve(const BeamMatrix& factor, NeedleBeam& rhs) {
  BeamVector &x = rhs.x, &y = rhs.y;
  for (std::size_t i = 0; i < kBeamUnknowns; i++) {
    const auto& row = factor.band[i];
    for (std::size_t k = std::min(i, kBand - 1); k > 0; k--)
      x[i] -= row[k] * x[i - k], y[i] -= row[k] * y[i - k];
    x[i] *= row[0], y[i] *= row[0];
  }
  for (std::size_t i = kBeamUnknowns; i-- > 0;) {
    const auto& row = factor.band[i];
    x[i] *= row[0], y[i] *= row[0];
    for (std::size_t k = 1; k <= std::min(i, kBand - 1); k++)
      x[i - k] -= row[k] * x[i], y[i - k] -= row[k] * y[i];
  }
}

BeamShape beam_shape(const Needle& needle, double behind) {
  const double h = needle.length / kBeamElements, s = std::clamp(behind, 0.0, needle.length);
  const int e = std::min(kBeamElements - 1, int(s / h));
  const double a = s / h - e, b = 1 - a;
  return {2 * e,
          {b * b * (1 + 2 * a), h * a * b * b, a * a * (1 + 2 * b), -h * a * a * b},
          {-6 * a * b / h, b * (1 - 3 * a), 6 * a * b / h, a * (1 - 3 * b)}};
}

Vec3d deflection(const NeedleBeam& beam, const BeamShape& at) {
  return {sum_over(beam.x, at, at.value), sum_over(beam.y, at, at.value), 0};
}
Vec3d deflection_slope(const NeedleBeam& beam, const BeamShape& at) {
  return {sum_over(beam.x, at, at.slope), sum_over(beam.y, at, at.slope), 0};
}

void add_load(const BeamShape& at, Vec3d force, NeedleBeam& load) {
  for (int k = 0; k < 4 && at.first + k < kBeamUnknowns; k++) {
    const auto i = std::size_t(at.first + k);
    load.x[i] += at.value[std::size_t(k)] * force.x;
    load.y[i] += at.value[std::size_t(k)] * force.y;
  }
}

double beam_energy(const Needle& needle, const NeedleBeam& beam) {
  const BeamMatrix stiffness = beam_stiffness(needle);
  return energy_in_plane(stiffness, beam.x) + energy_in_plane(stiffness, beam.y);
}

}  // namespace turgor::contact
