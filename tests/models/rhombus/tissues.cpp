#include "turgor/models/rhombus/tissues.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

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

// Presses of any ball are within 10 % of Sneddon's sphere at every depth.
TEST(RhombusTissues, PressesWithinTenPercentOfSneddon) {
  // Other radii and depths than in the fit, including depths where the force is 2.3 to 3.8 times that of
  // Hertz.
  double worst = 0;
  for (const Tissue& tissue : tissues()) {
    if (tissue.young == 0) continue;
    const Chain chain = *build_chain(tissue.chain);
    for (const double radius : {0.001, 0.0023, 0.0071, 0.015, 0.05})
      for (double fraction = 0.003; fraction < 2; fraction *= 1.13) {
        const double expected = sneddon_force(contact_modulus(tissue.young, 0.5), radius, fraction * radius);
        const double found = force_of_tip(chain, tip_on(chain, radius), fraction * radius);
        worst = std::max(worst, std::abs(found / expected - 1));
      }
  }
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
