// A textured surface under a hand, with the passivity controller on: a slide gives the hand no energy beyond
// that of one tick.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "turgor/contact/texture.hpp"
#include "turgor/haptics/passivity.hpp"
#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

constexpr double kPeriod = 1e-3;

/// Rough heights that repeat after 3.2 mm, without a period of their own.
contact::Texture rough_map() {
  std::uint32_t seed = 5;
  std::vector<double> height(32 * 32);
  for (double& h : height) h = 4e-6 * double((seed = seed * 1664525u + 1013904223u) >> 16) / 65536;
  return {.map = std::make_shared<const contact::HeightMap>(
              contact::make_height_map(32, 32, 2.5e-4, std::move(height)))};
}
contact::Texture steep_waves() { return {.waves = {1e-4, 2e-3}}; }

/// A light hand with little damping slides to and fro for four seconds, under the normal force N.
struct Slid {
  double given = 0;         // largest energy that the texture and its controller gave so far [J]
  double lowest = 0;        // of the observer [J]
  double largest = 0;       // force of the texture [N]
  double longest_step = 0;  // of the hand in a tick [m]
  int damped_ticks = 0;
};
Slid slide_over(const contact::Texture& texture, double normal_force, double damping, bool controlled) {
  VirtualArm arm{.viscous = 0.05, .coulomb = 0, .encoder = 1e-6};
  VirtualHand hand{.mass = 0.05, .damping = damping, .stiffness = 100};
  hand.target = [](double t) {
    HandTarget target;
    target.pose.position = {0.025 * std::sin(5 * t), 0.02 * std::sin(3.3 * t), 0};
    return target;
  };
  VirtualDevice device(arm, hand);
  EXPECT_TRUE(device.open());
  PassivityParams params;
  params.damping = largest_damping(device.spec(), kPeriod);
  Passivity passivity;
  contact::TextureState state;
  DeviceOutput output;
  DeviceInput input;
  Slid slid;
  double work = 0;  // of all forces on the hand, exact since a force is held for a tick
  Vec3d before = device.pose().position;
  for (int n = 0; n < 4000; n++) {
    EXPECT_TRUE(device.exchange(output, input));
    const Vec3d now = device.pose().position;
    work += dot(output.force, now - before);
    slid.longest_step = std::max(slid.longest_step, norm(now - before));
    before = now;
    slid.given = std::max(slid.given, work);
    observe(params, passivity, input.pose, kPeriod);
    DeviceOutput wanted;
    wanted.force =
        contact::texture_force(texture, state, {input.pose.position, {0, 0, 1}, normal_force, true}, kPeriod);
    bool damped = false;
    output = controlled ? add_passivity_damping(params, passivity, wanted, input, kPeriod, damped) : wanted;
    passivity.held_output = output;
    slid.damped_ticks += damped;
  }
  slid.lowest = passivity.lowest, slid.largest = state.largest_force;
  return slid;
}

// With the controller, the texture gives a hand no more than its largest force does in one tick, for waves
// steeper than a hand's damping allows and for a map of heights, whatever the hand's damping. Without it,
// waves give more than three times as much.
TEST(TexturePassivity, SlideGivesNoEnergy) {
  for (const double damping : {0.05, 0.3, 3.0})
    for (const contact::Texture& texture : {steep_waves(), rough_map()}) {
      const Slid with = slide_over(texture, 2, damping, true);
      const double tick = with.largest * with.longest_step;
      EXPECT_GT(with.largest, 0.02);
      EXPECT_GT(with.damped_ticks, 50);
      EXPECT_LT(with.given, tick) << "damping " << damping << ", map " << bool(texture.map);
      EXPECT_GT(with.lowest, -2 * tick);
      if (!texture.map) {
        EXPECT_GT(slide_over(texture, 2, damping, false).given, 3 * tick);
      }
    }
}

// A map's force is conservative: without any controller, a slide of four seconds gives at most the normal
// force times the range of heights.
TEST(TexturePassivity, MapGivesItsRangeAtMost) {
  const contact::Texture texture = rough_map();
  for (const double normal_force : {0.5, 2.0}) {
    const Slid slid = slide_over(texture, normal_force, 0.3, false);
    EXPECT_GT(slid.given, 0);
    EXPECT_LT(slid.given, normal_force * texture.map->range);
  }
}

}  // namespace
}  // namespace turgor::haptics
