#include "turgor/models/rhombus/chain.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace turgor::rhombus {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<Chain> chains() {
  std::vector<Chain> all = {*build_chain({})};
  for (const double angle : {10.0, 45.0, 80.0})
    for (const double decay : {0.4, 2.0, 15.0})
      all.push_back(*build_chain(
          {.normal = 40, .tangential = 25, .decay = decay, .angle = angle * kDegree, .side = 0.004}));
  return all;
}

/// Pulls and presses up to 10 kN, including very small ones.
std::vector<double> depths(const Chain& chain) {
  std::vector<double> all = {1e-9, -1e-9, 1e-6, -1e-6};
  for (double fraction = -0.3; fraction < 0.31; fraction += 0.0171) {
    const double depth = fraction * (fraction > 0 ? chain.deepest : chain.highest);
    if (std::abs(force_of_depth(chain, depth)) < 1e4) all.push_back(depth);
  }
  return all;
}

// The depth of a force and the force of a depth are inverse functions, from any initial guess.
TEST(RhombusChain, DepthAndForceAreInverse) {
  for (const Chain& chain : chains())
    for (const double depth : depths(chain)) {
      const double force = force_of_depth(chain, depth);
      EXPECT_NEAR(depth_of_force(chain, force).depth, depth, 1e-12);
      EXPECT_NEAR(force_of_depth(chain, depth, 1.7 * force) / force, 1, 1e-7) << "from another guess";
    }
}

// The force at a depth where a unit reaches its stop is found from any initial guess.
TEST(RhombusChain, SofteningDepthFromAnyGuess) {
  // The third unit reaches its stop: the stiffness of the chain falls from 16 000 N/m to 200 N/m.
  const Chain chain = *build_chain(
      {.normal = 161.8, .tangential = 13.3, .decay = 0.2, .angle = 0.576, .side = 0.00625, .stiffening = 1});
  for (const double depth : {0.0310, 0.0319, 0.0322, 0.0325, 0.0330})
    for (const double guess : {0.0, 1e-6, 90.0, 130.0, 136.0, 1e5})
      EXPECT_NEAR(depth_of_force(chain, force_of_depth(chain, depth, guess)).depth, depth, 1e-12) << guess;
}

// Depth, force, energy and shape of an undeformed chain are zero.
TEST(RhombusChain, ZeroDepthZeroForce) {
  for (const Chain& chain : chains()) {
    EXPECT_EQ(force_of_depth(chain, 0), 0);
    EXPECT_EQ(depth_of_force(chain, 0).depth, 0);
    EXPECT_EQ(chain_energy(chain, 0), 0);
    EXPECT_EQ(shape_of_force(chain, 0).units, 0);
  }
}

// The force increases with the depth and has no jumps.
TEST(RhombusChain, ForceIsMonotonicAndContinuous) {
  for (const Chain& chain : chains()) {
    const double low = std::max(depth_of_force(chain, -2).depth, -chain.highest);
    const double high = std::min(depth_of_force(chain, 2).depth, chain.deepest);
    const double step = (high - low) / 10000;
    double before = force_of_depth(chain, low);
    for (double depth = low + step; depth < high; depth += step) {
      const double force = force_of_depth(chain, depth, before);
      ASSERT_GT(force, before) << depth;
      // The slope is bounded by the stiffness at either end, so the force has no jump.
      const double stiffest =
          std::max(1 / depth_of_force(chain, force).compliance, 1 / depth_of_force(chain, before).compliance);
      ASSERT_LT(force - before, 2 * stiffest * step) << depth;
      before = force;
    }
  }
}

// The force is the derivative of the energy.
TEST(RhombusChain, ForceIsEnergyDerivative) {
  for (const Chain& chain : chains())
    for (const double depth : depths(chain)) {
      if (std::abs(depth) < 1e-7) continue;
      const double d = 1e-4 * std::abs(depth), force = force_of_depth(chain, depth);
      const double slope = (chain_energy(chain, force_of_depth(chain, depth + d)) -
                            chain_energy(chain, force_of_depth(chain, depth - d))) /
                           (2 * d);
      EXPECT_NEAR(slope / force, 1, 1e-4) << depth;
    }
}

// A press and release has no net work.
TEST(RhombusChain, ClosedCycleHasNoWork) {
  const Chain chain = *build_chain({});
  double work = 0, guess = 0, most = 0;
  const int steps = 2000;
  double before = 0;
  for (int i = 1; i <= 2 * steps; i++) {
    const double depth = 0.015 * (i <= steps ? i : 2 * steps - i) / steps;
    const double force = force_of_depth(chain, depth, guess);
    work += 0.5 * (force + guess) * (depth - before);
    most = std::max(most, work), before = depth, guess = force;
  }
  EXPECT_GT(most, 0);
  EXPECT_NEAR(work, 0, 1e-12 * most);
  EXPECT_EQ(guess, 0);
}

// The stiffness grows by exp(1/β) from unit to unit.
TEST(RhombusChain, StiffnessGrowsByExpOneOverBeta) {
  const Chain chain = *build_chain({});
  for (int i = 0; i < 20; i++)
    EXPECT_NEAR(chain.units[std::size_t(i)].tangential, 1.8 * std::exp(i / 2.0), 1e-9 * std::exp(i / 2.0));
}

// The chain ends where units rotate by less than 5 %.
TEST(RhombusChain, EndsBelowFivePercentRotation) {
  const Chain chain = *build_chain({});
  for (const double depth : {0.002, 0.01, 0.02, -0.002, -0.01}) {
    const double force = force_of_depth(chain, depth);
    const ChainDepth at = depth_of_force(chain, force);
    const auto turn = [&](int i) {
      const Unit& unit = chain.units[std::size_t(i)];
      const double l = rest_length(unit) + turn_by_force(unit, -force).normal_change;
      return std::abs(std::asin(l / (2 * unit.side)) / unit.angle - 1);
    };
    ASSERT_GT(at.units, 1);
    EXPECT_GE(turn(at.units - 1), 0.05 * (1 - 1e-9));
    EXPECT_LE(turn(at.units), 0.05 * (1 + 1e-9));
  }
}

// The deformed region grows with the logarithm of the force.
TEST(RhombusChain, RegionGrowsLogarithmically) {
  const Chain chain = *build_chain({});
  std::vector<int> units;
  for (double force = 0.005; force < 0.4; force *= 4) units.push_back(depth_of_force(chain, force).units);
  EXPECT_GT(units[1], units[0]);
  EXPECT_GT(units[2], units[1]);
  EXPECT_LE(units[3] - units[2], 4);  // four times the force: 2 ln 4 = 2.8 units more
}

// The shape is the depth on the axis and zero at the end.
TEST(RhombusChain, ShapeFromDepthToZero) {
  for (const Chain& chain : chains())
    for (const double depth : depths(chain)) {
      const ChainShape shape = shape_of_force(chain, force_of_depth(chain, depth));
      EXPECT_NEAR(shape_at(shape, 0).depth, depth, 1e-12);
      EXPECT_EQ(shape_at(shape, 0).outward, 0);
      EXPECT_NEAR(shape_at(shape, shape.units - 1e-9).depth, 0, 1e-9 * std::abs(depth));
      EXPECT_NEAR(shape_at(shape, shape.units - 1e-9).outward, 0, 1e-9 * std::abs(depth));
      EXPECT_EQ(shape_at(shape, shape.units).depth, 0);
      EXPECT_EQ(shape_at(shape, 1e9).outward, 0);
    }
}

// The shape decreases from the axis outward and never folds.
TEST(RhombusChain, ShapeDecreasesWithoutFolds) {
  for (const Chain& chain : chains())
    for (const double depth : depths(chain)) {
      const ChainShape shape = shape_of_force(chain, force_of_depth(chain, depth));
      ShapePoint before = shape_at(shape, 0);
      const double ds = 0.01, width = unit_width(chain);
      for (double s = ds; s < shape.units; s += ds) {
        const ShapePoint at = shape_at(shape, s);
        ASSERT_LE(std::abs(at.depth), std::abs(before.depth) * (1 + 1e-12));
        ASSERT_GT(ds * width + at.outward - before.outward, 0) << "passes its neighbor at " << s;
        ASSERT_GE(at.outward * depth, 0) << "outward for a press, inward for a pull";
        before = at;
      }
    }
}

// The growth of the stiffness with the force is within growth_bound.
TEST(RhombusChain, StiffnessGrowthIsBounded) {
  for (const Chain& chain : chains()) {
    const double bound = growth_bound(chain), soft = 1 / depth_of_force(chain, 0).compliance;
    for (double force = -50; force < 50; force += 0.37) {
      const double stiffness = 1 / depth_of_force(chain, force).compliance;
      EXPECT_LE(stiffness, (soft + bound * std::abs(force)) * (1 + 1e-9)) << force;
    }
  }
}

// Extreme depths have a finite force of the right sign.
TEST(RhombusChain, ExtremeDepthsHaveFiniteForce) {
  for (const Chain& chain : chains())
    for (const double depth : {1e3, -1e3, chain.deepest, -chain.highest, 1e300}) {
      const double force = force_of_depth(chain, depth);
      EXPECT_TRUE(std::isfinite(force)) << depth;
      EXPECT_GT(force * depth, 0);
    }
}

// Invalid parameters are rejected with a message.
TEST(RhombusChain, RejectsInvalidParameters) {
  const auto message = [](ChainParams p) {
    const Result<Chain> chain = build_chain(p);
    return chain ? std::string("built") : chain.error().message;
  };
  EXPECT_EQ(message({.angle = 0}),
            "the angle of the rhombi: expected more than 0 and less than 90 degrees, found 0");
  EXPECT_EQ(message({.angle = 90 * kDegree}),
            "the angle of the rhombi: expected more than 0 and less than 90 degrees, found 90");
  EXPECT_EQ(message({.normal = 0}),
            "normal stiffness k_N [N/m] of the rhombi: expected a number above 0, found 0");
  EXPECT_EQ(message({.tangential = -1.8}),
            "tangential stiffness k_T [N/m] of the rhombi: expected a number above 0, found -1.8");
  EXPECT_NE(message({.decay = std::nan("")}), "built");
  EXPECT_NE(message({.side = 0}), "built");
  EXPECT_NE(message({.boundary = 0}), "built");
  EXPECT_NE(message({.stiffening = 0}), "built");
  EXPECT_EQ(message({.tip = -1}), "the tip radius of the chain [m]: expected 0 or more, found -1");
}

}  // namespace
}  // namespace turgor::rhombus
