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

// A force at depth 0, and depths, forces and stiffnesses outside the range of chains are rejected.
TEST(RhombusCalibrate, RejectsCurvesOutOfRange) {
  const auto message = [](std::vector<CurvePoint> curve) {
    const Result<Fit> fit = calibrate(curve, {.tip = 0.005});
    return fit ? std::string("fitted") : fit.error().message;
  };
  EXPECT_EQ(message({{0, 400}, {4.5e-3, 1.7}, {5e-3, 2}, {5.5e-3, 2.3}, {6e-3, 2.6}, {7e-3, 2.8}, {8e-3, 3}}),
            "point 0 of the force-depth curve: expected no force at a depth of 0, found 400 N, more than a "
            "tenth of the largest force at other depths, 3 N");
  EXPECT_EQ(message({{1e-4, 1e300}, {2e-3, 1e300}, {3e-3, 1e301}, {4e-3, 1e302}, {5e-3, 1e303}}),
            "point 0 of the force-depth curve: expected a force of at most 1e+06 N, found 1e+300 N");
  EXPECT_EQ(
      message({{0, 0}, {4.5, 1.7}, {5, 2}, {5.5, 2.3}, {6, 2.6}}),
      "point 1 of the force-depth curve: expected a depth of at most 1 m, found 4.5 m; a column in mm is "
      "named depth_mm");
  EXPECT_EQ(message({{1e-6, 400}, {4.5e-3, 1.7}, {5e-3, 2}, {5.5e-3, 2.3}, {6e-3, 2.6}}),
            "the force-depth curve: expected a stiffness from 1e-06 to 1e+06 N/m, found 400 N at 1e-06 m");
  EXPECT_EQ(message({{1e-3, 1e-12}, {2e-3, 2e-12}, {3e-3, 3e-12}, {4e-3, 4e-12}}),
            "the force-depth curve: expected a stiffness from 1e-06 to 1e+06 N/m, found 4e-12 N at 0.004 m");
}

// Curves of any shape and magnitude within the range are fitted or rejected; parameters are finite.
TEST(RhombusCalibrate, AnyCurveInRangeGivesFiniteFit) {
  const double depths[] = {1e-300, 1e-12, 1e-6, 1e-3, 5e-3, 1};
  const double forces[] = {1e-308, 1e-12, 1e-3, 1, 400, 1e6};
  unsigned random = 1;
  const auto pick = [&](const double(&values)[6]) {
    random = random * 1664525u + 1013904223u;
    return values[(random >> 16) % 6];
  };
  int fitted = 0;
  for (int n = 0; n < 8; n++) {
    std::vector<CurvePoint> curve;
    for (int i = 0; i < 5; i++) {
      const double sign = i == 4 && n % 2 ? -1 : 1;
      curve.push_back({sign * pick(depths), sign * pick(forces)});
    }
    const Result<Fit> fit = calibrate(curve, {.tip = n % 3 ? 0.005 : 0});
    if (!fit) continue;
    fitted++;
    EXPECT_TRUE(std::isfinite(fit->rms) && std::isfinite(fit->largest)) << "curve " << n;
    EXPECT_TRUE(build_chain(fit->params)) << "curve " << n;
  }
  std::printf("%d of 8 curves fitted\n", fitted);
  EXPECT_GT(fitted, 1);
}

}  // namespace
}  // namespace turgor::rhombus
