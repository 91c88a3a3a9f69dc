#include "turgor/models/rhombus/tissues.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/models/rhombus/tip.hpp"

namespace turgor::rhombus {
namespace {

// "liver" is the measured human one; the paper's parameters have their author's name.
TEST(RhombusTissues, LiverIsMeasuredHumanLiver) {
  EXPECT_STREQ(tissues()[0].name, "liver");
  EXPECT_EQ(tissues()[0].young, 5400);
  const ChainParams& paper = find_tissue("zhang-2010")->chain;
  EXPECT_EQ(paper.normal, 1.5);
  EXPECT_EQ(paper.tangential, 1.8);
  EXPECT_EQ(paper.decay, 2);
  EXPECT_EQ(paper.boundary, 0.05);
}

// Every tissue builds a chain and names its source.
TEST(RhombusTissues, AllBuildAndNameSource) {
  for (const Tissue& tissue : tissues()) {
    EXPECT_TRUE(build_chain(tissue.chain)) << tissue.name;
    EXPECT_GT(std::string(tissue.source).size(), 20u);
    EXPECT_EQ(find_tissue(tissue.name), &tissue);
  }
  EXPECT_EQ(find_tissue("no tissue"), nullptr);
}

// Tissues with a modulus are the fit to a half space.
TEST(RhombusTissues, ModuliMatchHalfSpaceFit) {
  for (const Tissue& tissue : tissues()) {
    if (tissue.young == 0) continue;
    const Fit fit = *calibrate(half_space_curve(tissue.young, 0.005), tissue.chain);
    EXPECT_NEAR(fit.params.normal / tissue.chain.normal, 1, 1e-3) << tissue.name;
    EXPECT_NEAR(fit.params.tangential / tissue.chain.tangential, 1, 1e-2) << tissue.name;
    EXPECT_NEAR(fit.params.angle / tissue.chain.angle, 1, 1e-3) << tissue.name;
    EXPECT_LT(fit.largest, 0.10) << tissue.name;
    break;  // the others are multiples of this one
  }
}

/// Sneddon's sphere, parametrized by its contact radius a: the depth and force of E* = 1.
std::pair<double, double> sneddon(double radius, double a) {
  const double half_log = 0.5 * std::log((radius + a) / (radius - a));
  return {a * half_log, (a * a + radius * radius) * half_log - a * radius};
}

// Presses of any ball of 0.1 to 50 mm by up to six radii are within 10 % of Sneddon's sphere.
TEST(RhombusTissues, PressesWithinTenPercentOfSneddon) {
  // Random radii and depths; the fit has one radius, and no depth below two radii.
  std::mt19937 random(1965);
  std::uniform_real_distribution<double> fraction(0, 1);
  double worst = 0, deepest = 0;
  for (const Tissue& tissue : tissues()) {
    if (tissue.young == 0) continue;
    const Chain chain = *build_chain(tissue.chain);
    for (int press = 0; press < 4000; press++) {
      const double radius = 1e-4 * std::pow(500.0, fraction(random));
      const double a = radius * std::tanh(6 * std::pow(fraction(random), 3) + 0.03);
      const auto [depth, unit_force] = sneddon(radius, a);
      if (depth > 6 * radius) continue;
      const double found = force_of_tip(chain, tip_on(chain, radius), depth);
      worst = std::max(worst, std::abs(found / (tissue.young / 0.75 * unit_force) - 1));
      deepest = std::max(deepest, depth / radius);
    }
  }
  EXPECT_GT(deepest, 5.5) << "radii";
  std::printf("presses: largest difference from Sneddon %.1f %%\n", 100 * worst);
  EXPECT_LT(worst, 0.10);
}

// Small presses are within 3 % of Hertz.
TEST(RhombusTissues, SmallPressesWithinThreePercentOfHertz) {
  const Chain chain = *build_chain(tissues()[0].chain);
  for (const double radius : {0.002, 0.01, 0.1})
    for (const double fraction : {1e-4, 1e-3, 0.02}) {
      const double hertz = 4.0 / 3 * 5400 / 0.75 * std::sqrt(radius) * std::pow(fraction * radius, 1.5);
      EXPECT_NEAR(force_of_tip(chain, tip_on(chain, radius), fraction * radius) / hertz, 1, 0.03) << fraction;
    }
}

// Pulls are within 10 % of a disc up to a strain of 30 %.
TEST(RhombusTissues, PullsWithinTenPercentOfDisc) {
  const Chain chain = *build_chain(find_tissue("liver-porcine")->chain);
  for (const double radius : {0.0017, 0.005, 0.012})
    for (double pull = 0.01; pull <= 0.3 * std::numbers::pi; pull += 0.03) {
      const double disc = 2 * 12.5e3 / 0.75 * radius * pull * radius;
      EXPECT_NEAR(-force_of_tip(chain, tip_on(chain, radius), -pull * radius) / disc, 1, 0.10) << pull;
    }
}

// A porcine liver pulled by 20 mm has a force below 10 N.
TEST(RhombusTissues, PorcineLiverPullBelowTenNewtons) {
  const Chain chain = *build_chain(find_tissue("liver-porcine")->chain);
  const double force = -force_of_tip(chain, tip_on(chain, 0.005), -0.02);
  std::printf("porcine liver pulled by 20 mm: %.2f N\n", force);
  EXPECT_GT(force, 2 * 12.5e3 / 0.75 * 0.005 * 0.02) << "N; a linear disc";
  EXPECT_LT(force, 10);
}

}  // namespace
}  // namespace turgor::rhombus
