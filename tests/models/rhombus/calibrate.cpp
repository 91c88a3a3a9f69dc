#include <cmath>

#include <gtest/gtest.h>

#include "turgor/models/rhombus/half_space.hpp"

namespace turgor::rhombus {
namespace {

// Calibration recovers the parameters of a chain from its own force-depth curve.
TEST(RhombusCalibrate, RecoversChainFromItsCurve) {
  const ChainParams truth{.normal = 25, .tangential = 40, .decay = 1.4, .angle = 0.9, .side = 0.006};
  const Chain chain = *build_chain(truth);
  std::vector<CurvePoint> curve;
  for (double depth = -0.006; depth < 0.0121; depth += 0.0005)
    curve.push_back({depth, force_of_depth(chain, depth)});
  ChainParams start;
  start.side = truth.side;
  const Fit fit = *calibrate(curve, start);
  std::printf("own curve: largest residual %.2e of the peak after %d curves\n", fit.largest, fit.evaluations);
  EXPECT_LT(fit.largest, 1e-4);
  EXPECT_NEAR(fit.params.normal / truth.normal, 1, 0.02);
  EXPECT_NEAR(fit.params.tangential / truth.tangential, 1, 0.05);
  EXPECT_NEAR(fit.params.decay / truth.decay, 1, 0.05);
  EXPECT_NEAR(fit.params.angle / truth.angle, 1, 0.02);
}

// The fit to a pressed ball and a pulled disc is within 10 % of every force.
TEST(RhombusCalibrate, HalfSpaceWithinTenPercent) {
  for (const double radius : {0.003, 0.005, 0.02}) {
    ChainParams start;
    start.tip = radius, start.side = 1.25 * radius, start.stiffening = 1;
    const Fit fit = *calibrate(half_space_curve(3e3, radius), start);
    std::printf(
        "half space, %.0f mm: k_N %.4f k_T1 %.4f N/m, beta %.3f, theta %.6f: rms %.4f, largest %.4f\n",
        radius * 1e3, fit.params.normal, fit.params.tangential, fit.params.decay, fit.params.angle, fit.rms,
        fit.largest);
    EXPECT_LT(fit.largest, 0.10);
  }
}

// The fit to a linear spring is within 5 %.
TEST(RhombusCalibrate, LinearSpringWithinFivePercent) {
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= 30; i++) curve.push_back({0.01 * i / 30, 120.0 * 0.01 * i / 30});
  const Fit fit = *calibrate(curve, {});
  std::printf("linear: k_N %.3f k_T1 %.3f N/m, beta %.3f, theta %.2f deg: rms %.4f, largest %.4f\n",
              fit.params.normal, fit.params.tangential, fit.params.decay, fit.params.angle * 57.29578,
              fit.rms, fit.largest);
  EXPECT_LT(fit.largest, 0.05);
}

// Curves with too few points, wrong signs or NaN are rejected with a message.
TEST(RhombusCalibrate, RejectsUselessCurves) {
  const auto message = [](std::vector<CurvePoint> curve) {
    const Result<Fit> fit = calibrate(curve, {});
    return fit ? std::string("fitted") : fit.error().message;
  };
  EXPECT_EQ(message({}),
            "the force-depth curve: expected at least 4 points with a depth and a force, found 0");
  EXPECT_EQ(message({{0, 0}, {1e-3, 0.1}, {2e-3, -0.2}, {3e-3, 0.3}, {4e-3, 0.4}}),
            "point 2 of the force-depth curve: expected a force that resists, found -0.2 N at 0.002 m");
  EXPECT_NE(message({{1e-3, std::nan("")}}), "fitted");
}

}  // namespace
}  // namespace turgor::rhombus
