#include "turgor/contact/needle_beam.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

constexpr std::size_t kBand = 4;

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

// Both planes at once: each alone waits for its last entry. Three zeros before and after the entries spare
// the first and last rows loops of their own.
void solve(const BeamMatrix& factor, NeedleBeam& rhs) {
  constexpr std::size_t kRim = kBand - 1;
  double x[kBeamUnknowns + 2 * kRim], y[kBeamUnknowns + 2 * kRim];
  for (std::size_t k = 0; k < kRim; k++)
    x[k] = y[k] = x[kRim + kBeamUnknowns + k] = y[kRim + kBeamUnknowns + k] = 0;
  // forward; entries left of the matrix are zero
  for (std::size_t i = 0; i < kBeamUnknowns; i++) {
    const auto& row = factor.band[i];
    double *u = x + kRim + i, *v = y + kRim + i;
    u[0] = (rhs.x[i] - row[3] * u[-3] - row[2] * u[-2] - row[1] * u[-1]) * row[0];
    v[0] = (rhs.y[i] - row[3] * v[-3] - row[2] * v[-2] - row[1] * v[-1]) * row[0];
  }
  // backward
  const auto below = [&](std::size_t i, std::size_t k) {
    return i + k < kBeamUnknowns ? factor.band[i + k][k] : 0;
  };
  for (std::size_t i = kBeamUnknowns; i-- > 0;) {
    const double one = below(i, 1), two = below(i, 2), three = below(i, 3), own = factor.band[i][0];
    double *u = x + kRim + i, *v = y + kRim + i;
    rhs.x[i] = u[0] = (u[0] - three * u[3] - two * u[2] - one * u[1]) * own;
    rhs.y[i] = v[0] = (v[0] - three * v[3] - two * v[2] - one * v[1]) * own;
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

double beam_energy(const Needle& needle, const NeedleBeam& beam) {
  const BeamMatrix stiffness = beam_stiffness(needle);
  return energy_in_plane(stiffness, beam.x) + energy_in_plane(stiffness, beam.y);
}

}  // namespace turgor::contact
