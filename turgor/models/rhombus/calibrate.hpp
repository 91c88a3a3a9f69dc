// Finds the chain that answers like a measured (or otherwise computed) force–depth curve.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

/// A place of a force–depth curve; pressing is positive, pulling negative.
struct CurvePoint {
  double depth = 0;  // [m]
  double force = 0;  // [N]
};

/// Residuals are relative: fractions of the curve's own force, or of this share of the largest where it is
/// smaller than that, so that the first hair's breadth of a measured press does not decide.
constexpr double kFitFloor = 0.02;

struct Fit {
  ChainParams params;
  double rms = 0;       // of the residuals [1]
  double largest = 0;   // residual [1]
  int evaluations = 0;  // of the whole curve
};

/// Least squares of the relative residuals by Levenberg and Marquardt over k_N, k_T1, β and θ, which stay
/// positive, β in [0.2, 30] and θ in [2°, 88°], from several starts; all else is that of `start`, with `tip`
/// the radius of the ball that pressed. Error: fewer than four points off the origin, numbers that are none,
/// a force against its depth, no force at all.
Result<Fit> calibrate(std::span<const CurvePoint> curve, const ChainParams& start);

}  // namespace turgor::rhombus
