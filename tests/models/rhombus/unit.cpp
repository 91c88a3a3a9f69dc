#include "turgor/models/rhombus/unit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace turgor::rhombus {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<Unit> units() {
  std::vector<Unit> all;
  for (const double angle : {2.0, 20.0, 45.0, 70.0, 88.0})
    for (const double tangential : {0.01, 1.8, 300.0})
      for (const double stiffening : {1.0, 10.0})
        all.push_back(make_unit(0.005, angle * kDegree, 1.5, tangential, stiffening));
  return all;
}

/// Rotations from nearly flat to nearly upright.
std::vector<double> turns(const Unit& unit) {
  std::vector<double> all;
  for (double fraction = -0.98; fraction < 0.99; fraction += 0.0613)
    all.push_back(fraction * (fraction < 0 ? unit.angle : 90 * kDegree - unit.angle));
  return all;
}

// The diagonals change as the sides rotate.
TEST(RhombusUnit, DiagonalsFollowRotation) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const double l = 2 * unit.side * std::sin(unit.angle + turn),
                   v = 2 * unit.side * std::cos(unit.angle + turn);
      EXPECT_NEAR(normal_change(unit, turn), l - rest_length(unit), 1e-17);
      EXPECT_NEAR(tangential_change(unit, turn), v - rest_width(unit), 1e-17);
      EXPECT_NEAR(tangential_change(unit, turn), -std::tan(unit.angle + turn / 2) * normal_change(unit, turn),
                  1e-15);
    }
}

// The force is the derivative of the energy by the length.
TEST(RhombusUnit, ForceIsEnergyDerivative) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const double d = 1e-6 * unit.angle;
      const double dl = normal_change(unit, turn + d) - normal_change(unit, turn - d);
      const double slope = (unit_energy(unit, turn + d) - unit_energy(unit, turn - d)) / dl;
      const double scale = std::abs(unit_force(unit, turn)) + unit.normal * rest_length(unit) * 1e-3;
      EXPECT_NEAR(slope, unit_force(unit, turn), 2e-5 * scale) << unit.angle / kDegree << " " << turn;
    }
}

// The stiffness is the derivative of the force.
TEST(RhombusUnit, StiffnessIsForceDerivative) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const double d = 1e-6 * unit.angle;
      const double dl = normal_change(unit, turn + d) - normal_change(unit, turn - d);
      const double slope = (unit_force(unit, turn + d) - unit_force(unit, turn - d)) / dl;
      EXPECT_NEAR(slope / unit_stiffness(unit, turn), 1, 2e-4) << unit.angle / kDegree << " " << turn;
    }
}

// Both springs resist a small rotation as in the paper's force balance.
TEST(RhombusUnit, SmallRotationMatchesPaper) {
  // Equations (1)-(3) of the paper: F = k_N Δl + k_T |Δv| tan θ. Its equation (6) has the wrong sign in the
  // second term.
  const Unit unit = make_unit(0.005, 45 * kDegree, 1.5, 1.8, 10);
  const double turn = -1e-6;
  const double balance =
      1.5 * normal_change(unit, turn) - 1.8 * tangential_change(unit, turn) * std::tan(45 * kDegree);
  EXPECT_NEAR(unit_force(unit, turn) / balance, 1, 1e-5);
  EXPECT_LT(1.5 - 1.8 * std::tan(45 * kDegree) * std::tan(45 * kDegree), 0)
      << "the printed chain's stiffness";
}

// A unit is never softer than its normal spring.
TEST(RhombusUnit, NeverSofterThanNormalSpring) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) EXPECT_GE(unit_stiffness(unit, turn), unit.normal * (1 - 1e-9));
}

// The stiffness grows by at most a factor e over a known length.
TEST(RhombusUnit, StiffnessGrowthIsBounded) {
  for (const Unit& unit : units()) {
    const double pressed = unit.side * std::sqrt(1 - std::pow(std::cos(unit.angle), 2.0 / 3));
    const double fastest = 1 / std::min(pressed, unit.pulled.rise);
    for (const double force : {-1e4, -30.0, -1.0, -1e-3, 1e-3, 1.0, 30.0, 1e4}) {
      const double more = force * (1 + 1e-4);
      const double growth = (turn_by_force(unit, more).stiffness - turn_by_force(unit, force).stiffness) /
                            std::abs(more - force);
      EXPECT_LE(growth, fastest * (1 + 1e-3)) << unit.angle / kDegree << " " << force;
    }
  }
}

// Force, energy and stiffness are continuous at the stops.
TEST(RhombusUnit, StopsAreSmooth) {
  for (const Unit& unit : units())
    for (const UnitStop& stop : {unit.pressed, unit.pulled}) {
      const double turn = std::atan(stop.tangent) - unit.angle, d = 1e-9 * unit.angle;
      if (turn == 0) continue;  // already stiffer at rest than the stop allows
      EXPECT_NEAR(unit_force(unit, turn - d) / unit_force(unit, turn + d), 1, 1e-5);
      EXPECT_NEAR(unit_energy(unit, turn - d) / unit_energy(unit, turn + d), 1, 1e-5);
      EXPECT_NEAR(unit_stiffness(unit, turn - d) / unit_stiffness(unit, turn + d), 1, 1e-5);
    }
}

// The rotation under a force has that force.
TEST(RhombusUnit, RotationOfForceIsInverse) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const TurnedUnit found = turn_by_force(unit, unit_force(unit, turn));
      EXPECT_NEAR(found.normal_change, normal_change(unit, turn), 1e-9 * unit.side) << turn;
      const double width_turn =  // beyond a stop the width is constant
          std::clamp(turn, std::atan(unit.pressed.tangent) - unit.angle,
                     std::atan(unit.pulled.tangent) - unit.angle);
      EXPECT_NEAR(found.tangential_change, tangential_change(unit, width_turn), 1e-8 * unit.side) << turn;
      EXPECT_NEAR(found.stiffness / unit_stiffness(unit, turn), 1, 1e-6) << turn;
    }
}

// Extreme forces give finite lengths and stiffnesses.
TEST(RhombusUnit, ExtremeForcesStayFinite) {
  for (const Unit& unit : units())
    for (const double force : {-1e300, -1e9, 1e9, 1e150}) {
      const TurnedUnit found = turn_by_force(unit, force);
      EXPECT_TRUE(std::isfinite(found.normal_change) && std::isfinite(found.stiffness));
      EXPECT_GT(found.normal_change * force, 0);
      EXPECT_LT(std::abs(found.normal_change), 1000 * std::max(unit.pressed.rise, unit.pulled.rise));
    }
}

}  // namespace
}  // namespace turgor::rhombus
