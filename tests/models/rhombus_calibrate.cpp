#include <cmath>

#include <gtest/gtest.h>

#include "turgor/models/rhombus/calibrate.hpp"

namespace turgor::rhombus {
namespace {

/// A ball of radius r pressed into a half-space of modulus E. [Hertz]
std::vector<CurvePoint> hertz(double young, double poisson, double radius, double deepest) {
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= 40; i++) {
    const double d = deepest * i / 40;
    curve.push_back({d, 4.0 / 3 * young / (1 - poisson * poisson) * std::sqrt(radius) * std::pow(d, 1.5)});
  }
  return curve;
}

TEST(RhombusCalibrate, it_finds_a_chain_from_its_own_curve) {
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

TEST(RhombusCalibrate, it_reproduces_a_ball_on_an_elastic_half_space_within_5_percent_of_the_peak) {
  for (const double deepest : {0.005, 0.010}) {
    const Fit fit = *calibrate(hertz(3e3, 0.5, 0.005, deepest), {});
    std::printf(
        "Hertz to %.0f mm: k_N %.3f k_T1 %.3f N/m, beta %.3f, theta %.2f deg: rms %.4f, largest %.4f\n",
        deepest * 1e3, fit.params.normal, fit.params.tangential, fit.params.decay,
        fit.params.angle * 57.29578, fit.rms, fit.largest);
    EXPECT_LT(fit.largest, 0.05);
  }
}

TEST(RhombusCalibrate, a_linear_spring_is_reproduced_within_5_percent_of_the_peak) {
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= 30; i++) curve.push_back({0.01 * i / 30, 120.0 * 0.01 * i / 30});
  const Fit fit = *calibrate(curve, {});
  std::printf("linear: k_N %.3f k_T1 %.3f N/m, beta %.3f, theta %.2f deg: rms %.4f, largest %.4f\n",
              fit.params.normal, fit.params.tangential, fit.params.decay, fit.params.angle * 57.29578,
              fit.rms, fit.largest);
  EXPECT_LT(fit.largest, 0.05);
}

TEST(RhombusCalibrate, curves_that_say_nothing_are_refused_with_a_sentence) {
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
