// Shaft of a needle that bends: an Euler–Bernoulli beam of equal cubic elements, clamped in the hand at the
// end of the shaft, with small deflections across it. needle_bend.cpp couples it to the tissue.
//
//     EI w'''' = −f        w(L) = w'(L) = 0,   w''(0) = w'''(0) = 0       (at the distance s behind the tip)
//
// f is the force per length on the tissue. Axial forces do not bend the beam.
#pragma once

#include <array>
#include <cstddef>

#include "turgor/contact/needle.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::contact {

constexpr int kBeamElements = 20;
constexpr int kBeamUnknowns = 2 * kBeamElements;  // deflection and slope of every node but the clamped one

/// A load, or a deflection [m] and its slope by s [1], of every node from the tip on.
using BeamVector = std::array<double, kBeamUnknowns>;

/// Deflection in the planes of the tool's x and y axes.
struct NeedleBeam {
  BeamVector x{}, y{};
};

/// Symmetric matrix with a half bandwidth of 3, or its Cholesky factor: band[i][k] is the entry (i, i − k).
/// The diagonal of a factor is stored as its reciprocal.
struct BeamMatrix {
  std::array<std::array<double, 4>, kBeamUnknowns> band{};
};
/// Stiffness of a beam.
BeamMatrix beam_stiffness(const Needle& needle);
/// Replaces a positive definite matrix by its Cholesky factor.
void factorize(BeamMatrix& matrix);
/// Solves with the factor in both planes, in place.
void solve(const BeamMatrix& factor, NeedleBeam& rhs);

/// Cubic shape functions of an element at a distance behind the tip. Values of the clamped node are zero.
struct BeamShape {
  int first = 0;                  // unknown of the element
  std::array<double, 4> value{};  // of the deflection
  std::array<double, 4> slope{};  // of its derivative by s [1/m]
};
BeamShape beam_shape(const Needle& needle, double behind);

/// Calls visit(k, unknown) for the values of the shape functions that are not those of the clamped node.
/// Loops of a known length: a tick calls this some hundred times.
template <class Visit>
[[gnu::always_inline]] inline void for_each_unknown(const BeamShape& at, const Visit& visit) {
  const auto first = std::size_t(at.first);
  visit(std::size_t(0), first), visit(std::size_t(1), first + 1);
  if (at.first + 4 <= kBeamUnknowns) visit(std::size_t(2), first + 2), visit(std::size_t(3), first + 3);
}
/// Deflection and its derivative by s, in the tool's frame; z is 0 [m] [1].
inline Vec3d deflection(const NeedleBeam& beam, const BeamShape& at) {
  Vec3d sum;
  for_each_unknown(at, [&](std::size_t k, std::size_t i) {
    sum.x += at.value[k] * beam.x[i], sum.y += at.value[k] * beam.y[i];
  });
  return sum;
}
inline Vec3d deflection_slope(const NeedleBeam& beam, const BeamShape& at) {
  Vec3d sum;
  for_each_unknown(at, [&](std::size_t k, std::size_t i) {
    sum.x += at.slope[k] * beam.x[i], sum.y += at.slope[k] * beam.y[i];
  });
  return sum;
}
/// Deflection of the tip [m].
inline Vec3d at_tip(const NeedleBeam& beam) { return {beam.x[0], beam.y[0], 0}; }
/// A vector across the shaft in the world.
inline Vec3d in_world(const Mat3d& axes, Vec3d across) {
  return axes.column[0] * across.x + axes.column[1] * across.y;
}
/// Adds a force on the beam, in the tool's frame [N].
inline void add_load(const BeamShape& at, Vec3d force, NeedleBeam& load) {
  for_each_unknown(at, [&](std::size_t k, std::size_t i) {
    load.x[i] += at.value[k] * force.x, load.y[i] += at.value[k] * force.y;
  });
}
/// beam += more · factor
inline void add_scaled(NeedleBeam& beam, const NeedleBeam& more, double factor) {
  for (std::size_t i = 0; i < kBeamUnknowns; i++)
    beam.x[i] += more.x[i] * factor, beam.y[i] += more.y[i] * factor;
}
/// Elastic energy of the deflected beam [J].
double beam_energy(const Needle& needle, const NeedleBeam& beam);

}  // namespace turgor::contact
