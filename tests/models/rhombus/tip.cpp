#include "turgor/models/rhombus/tip.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turgor/models/rhombus/tissues.hpp"

namespace turgor::rhombus {
namespace {

const ChainParams kTissue = chain_of_modulus(4e3);

// Twice the radius at twice the depth gives four times the force.
TEST(RhombusTip, ForceScalesWithRadiusSquared) {
  const Chain chain = *build_chain(kTissue);
  for (const double depth : {-0.02, -0.003, 1e-5, 0.002, 0.009})
    for (const double radius : {0.003, 0.011})
      EXPECT_NEAR(force_of_tip(chain, tip_on(chain, 2 * radius), 2 * depth) /
                      (4 * force_of_tip(chain, tip_on(chain, radius), depth)),
                  1, 1e-6);
}

// The force is the derivative of the energy.
TEST(RhombusTip, ForceIsEnergyDerivative) {
  const Chain chain = *build_chain(kTissue);
  for (const double radius : {0.0002, 0.003, 0.005, 0.02}) {
    const Tip tip = tip_on(chain, radius);
    for (const double fraction : {-3.0, -0.8, -0.1, 0.001, 0.03, 0.4, 1.3, 2.0, 2.05, 2.5, 4.3, 9.0}) {
      const double depth = fraction * radius, d = 1e-4 * std::abs(depth);
      const auto work = [&](double x) { return tip_energy(chain, tip, x, chain_force(chain, tip, x)); };
      const double slope = (work(depth + d) - work(depth - d)) / (2 * d);
      EXPECT_NEAR(slope / force_of_tip(chain, tip, depth), 1, 1e-4) << fraction;
    }
  }
}

// The equivalent disc stores the energy of Sneddon's sphere.
TEST(RhombusTip, DiscEnergyMatchesSneddon) {
  // u² / R² = ∫ F dd / (E* R³), by the trapezoidal rule over the contact radius.
  const Tip tip{0.01, 1};
  double work = 0, last_depth = 0, last_force = 0;
  for (double fraction = 1e-3; fraction < 0.9995; fraction += 1e-4) {
    const double arc = std::atanh(fraction), depth = fraction * arc,
                 force = (1 + fraction * fraction) * arc - fraction;
    work += 0.5 * (force + last_force) * (depth - last_depth);
    last_depth = depth, last_force = force;
    if (depth > 1e-3) {
      EXPECT_NEAR(disc_depth(tip, depth * 0.01).depth / (std::sqrt(work) * 0.01), 1, 0.01) << depth;
    }
  }
  EXPECT_GT(last_depth, 4);
}

// The depth of a force has that force.
TEST(RhombusTip, DepthOfForceIsInverse) {
  const Chain chain = *build_chain(kTissue), paper = *build_chain({});
  for (const double force : {1e-4, 0.01, 0.3, 4.0}) {
    const Tip tip = tip_on(chain, 0.008);
    EXPECT_NEAR(force_of_tip(chain, tip, depth_of_tip(chain, tip, force)) / force, 1, 1e-6);
    EXPECT_NEAR(force_of_depth(paper, depth_of_tip(paper, tip_on(paper, 0.008), force)) / force, 1, 1e-6);
  }
}

// The force of the paper's chain does not depend on the tip's radius.
TEST(RhombusTip, PaperChainIgnoresTipRadius) {
  const Chain paper = *build_chain({});
  for (const double radius : {0.0, 0.002, 0.03})
    for (const double depth : {-0.01, 0.004})
      EXPECT_EQ(force_of_tip(paper, tip_on(paper, radius), depth), force_of_depth(paper, depth));
}

// A tip of zero radius has the force of the smallest radius: 0.1 mm that presses, 0.5 mm that holds.
TEST(RhombusTip, SharpTipHasMinimumRadius) {
  const Chain chain = *build_chain(kTissue);
  const Tip sharp = tip_on(chain, 0);
  EXPECT_EQ(force_of_tip(chain, sharp, 5e-4), force_of_tip(chain, tip_on(chain, 1e-4), 5e-4));
  EXPECT_EQ(force_of_tip(chain, sharp, -0.003), force_of_tip(chain, tip_on(chain, 5e-4), -0.003));
  EXPECT_GT(force_of_tip(chain, sharp, 5e-4), 0);
}

// The force and its slope have no step where the chain begins to grow, at two radii.
TEST(RhombusTip, ForceIsSmoothAtTwoRadii) {
  const Chain chain = *build_chain(kTissue);
  const Tip tip = tip_on(chain, 0.004);
  double before = force_of_tip(chain, tip, 0.0075), slope_before = 0;
  for (double depth = 0.00751; depth < 0.0085; depth += 1e-5) {
    const double force = force_of_tip(chain, tip, depth), slope = (force - before) / 1e-5;
    EXPECT_GT(slope, 0) << depth;
    if (slope_before > 0) {
      EXPECT_NEAR(slope / slope_before, 1, 0.03) << depth;
    }
    before = force, slope_before = slope;
  }
}

}  // namespace
}  // namespace turgor::rhombus
