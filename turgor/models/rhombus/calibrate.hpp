// Fits a chain to a measured or computed force–depth curve.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/chain.hpp"

namespace turgor::rhombus {

/// Point of a force–depth curve; pressing is positive, pulling negative.
struct CurvePoint {
  double depth = 0;  // [m]
  double force = 0;  // [N]
};

/// Residuals are relative to the curve's own force, or to this fraction of the largest force where the own
/// force is smaller. So the first contact of a measured press does not dominate the fit.
constexpr double kFitFloor = 0.02;

struct Fit {
  ChainParams params;
  double rms = 0;       // of the residuals [1]
  double largest = 0;   // residual [1]
  int evaluations = 0;  // of the whole curve
};

/// Least squares of the relative residuals by Levenberg and Marquardt over k_N, k_T1, β and θ, from several
/// starting points. All stay positive, with β in [0.2, 30] and θ in [2°, 88°]. Other parameters are those of
/// `start`, with `tip` the radius of the pressing ball. Error: fewer than four points off the origin, values
/// that are not finite, a force opposite to its depth, no force at all, a force at depth 0 above a tenth of
/// the largest, depths above 1 m, forces above kMostForce, or a stiffness outside 1e-6 to 1e6 N/m.
Result<Fit> calibrate(std::span<const CurvePoint> curve, const ChainParams& start);

}  // namespace turgor::rhombus
