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

/// Turns from nearly flat to nearly upright.
std::vector<double> turns(const Unit& unit) {
  std::vector<double> all;
  for (double part = -0.98; part < 0.99; part += 0.0613)
    all.push_back(part * (part < 0 ? unit.angle : 90 * kDegree - unit.angle));
  return all;
}

TEST(RhombusUnit, diagonals_change_as_the_sides_turn) {
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

TEST(RhombusUnit, the_force_is_the_derivative_of_the_energy_by_the_length) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const double d = 1e-6 * unit.angle;
      const double dl = normal_change(unit, turn + d) - normal_change(unit, turn - d);
      const double slope = (unit_energy(unit, turn + d) - unit_energy(unit, turn - d)) / dl;
      const double scale = std::abs(unit_force(unit, turn)) + unit.normal * rest_length(unit) * 1e-3;
      EXPECT_NEAR(slope, unit_force(unit, turn), 2e-5 * scale) << unit.angle / kDegree << " " << turn;
    }
}

TEST(RhombusUnit, the_stiffness_is_the_derivative_of_the_force) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const double d = 1e-6 * unit.angle;
      const double dl = normal_change(unit, turn + d) - normal_change(unit, turn - d);
      const double slope = (unit_force(unit, turn + d) - unit_force(unit, turn - d)) / dl;
      EXPECT_NEAR(slope / unit_stiffness(unit, turn), 1, 2e-4) << unit.angle / kDegree << " " << turn;
    }
}

TEST(RhombusUnit, both_springs_resist_a_small_turn_as_the_paper_s_force_balance_says) {
  // (1)-(3) of the paper: F = k_N Δl + k_T |Δv| tan θ; its (6) has the second term with the wrong sign.
  const Unit unit = make_unit(0.005, 45 * kDegree, 1.5, 1.8, 10);
  const double turn = -1e-6;
  const double balance =
      1.5 * normal_change(unit, turn) - 1.8 * tangential_change(unit, turn) * std::tan(45 * kDegree);
  EXPECT_NEAR(unit_force(unit, turn) / balance, 1, 1e-5);
  EXPECT_LT(1.5 - 1.8 * std::tan(45 * kDegree) * std::tan(45 * kDegree), 0)
      << "the printed chain's stiffness";
}

TEST(RhombusUnit, it_is_never_softer_than_its_normal_spring) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) EXPECT_GE(unit_stiffness(unit, turn), unit.normal * (1 - 1e-9));
}

TEST(RhombusUnit, its_stiffness_grows_by_e_over_a_stated_length_and_no_faster) {
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

TEST(RhombusUnit, the_stops_take_over_without_a_step_in_force_energy_or_stiffness) {
  for (const Unit& unit : units())
    for (const UnitStop& stop : {unit.pressed, unit.pulled}) {
      const double turn = std::atan(stop.tangent) - unit.angle, d = 1e-9 * unit.angle;
      if (turn == 0) continue;  // stiffer from the start than it may become
      EXPECT_NEAR(unit_force(unit, turn - d) / unit_force(unit, turn + d), 1, 1e-5);
      EXPECT_NEAR(unit_energy(unit, turn - d) / unit_energy(unit, turn + d), 1, 1e-5);
      EXPECT_NEAR(unit_stiffness(unit, turn - d) / unit_stiffness(unit, turn + d), 1, 1e-5);
    }
}

TEST(RhombusUnit, the_turn_under_a_force_has_that_force) {
  for (const Unit& unit : units())
    for (const double turn : turns(unit)) {
      const TurnedUnit found = turn_by_force(unit, unit_force(unit, turn));
      EXPECT_NEAR(found.normal_change, normal_change(unit, turn), 1e-9 * unit.side) << turn;
      const double width_turn =  // past a stop the width stays
          std::clamp(turn, std::atan(unit.pressed.tangent) - unit.angle,
                     std::atan(unit.pulled.tangent) - unit.angle);
      EXPECT_NEAR(found.tangential_change, tangential_change(unit, width_turn), 1e-8 * unit.side) << turn;
      EXPECT_NEAR(found.stiffness / unit_stiffness(unit, turn), 1, 1e-6) << turn;
    }
}

TEST(RhombusUnit, forces_beyond_all_measure_do_not_break_it) {
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
