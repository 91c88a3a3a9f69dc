// Needles in tissue or through surfaces of toughness 0: they tear at once, and friction and the load of the
// spread crack are all that resists.
#include <array>

#include <gtest/gtest.h>

#include "tests/contact/needle_insertion.hpp"
#include "tests/contact/needle_push.hpp"

namespace turgor::contact {
namespace {

using test_needles::above;
using test_needles::firm_block;
using test_needles::Held;
using test_needles::Insertion;
using test_needles::LatticeNeedleBlock;
using test_needles::make_block;
using test_needles::NeedleBlock;
using test_needles::NeedlePush;
using test_needles::soft_block;

constexpr double kDeep = 0.02;  // [m]

/// Friction and load of the spread crack at an inserted length [N].
double force_without_tearing(const Needle& needle, double inserted) {
  return needle.friction * inserted + spreading_force(needle, {inserted, 0});
}

/// Inserts a needle, and takes it out again.
void expect_no_resistance_of_tip(const NeedleBlock& block, const Needle& needle, double tilt) {
  Insertion insertion = above(block, needle, tilt, 0.7);
  double force = 0, cutting = 0;
  insertion.move_to(kDeep, 4e-5, [&](double depth, double along) {
    if (depth > 0.015) cutting = std::max(cutting, insertion.state.tip_force);
    force = along;
  });
  const double inserted = insertion.state.inserted;
  EXPECT_NEAR(inserted, kDeep, 1e-3);
  EXPECT_LT(cutting, 1e-3);
  EXPECT_NEAR(force, force_without_tearing(needle, inserted), 0.02 * force);
  EXPECT_NEAR(insertion.energy_error(), 0, 0.01);
  insertion.move_to(-0.004);
  EXPECT_EQ(insertion.state.phase, NeedlePhase::kOutside);
  EXPECT_EQ(norm(insertion.state.force), 0);
  EXPECT_EQ(insertion.state.punctures, 1);
}

// Tissue without toughness below a surface that has one, and all without: rigid shafts, upright and tilted.
TEST(NeedleLeastToughness, RigidShaftMeetsFrictionOnly) {
  for (const double entry : {328.0, 0.0})
    for (const double tilt : {0.0, 0.3})
      expect_no_resistance_of_tip(soft_block(), {.toughness = 0, .entry_toughness = entry}, tilt);
}

// A shaft that bends.
TEST(NeedleLeastToughness, BendingShaftMeetsFrictionOnly) {
  for (const double entry : {328.0, 0.0})
    for (const double tilt : {0.0, 0.3})
      expect_no_resistance_of_tip(
          soft_block(),
          {.toughness = 0, .entry_toughness = entry, .bending = bending_stiffness(0.001, kSteel)}, tilt);
}

// The surface of the body does not resist, the tissue behind it does.
TEST(NeedleLeastToughness, SoftSurfaceIsPuncturedOnce) {
  Insertion insertion = above(soft_block(), {.toughness = 164, .entry_toughness = 0}, 0.2, 0.7);
  insertion.move_to(kDeep);
  EXPECT_EQ(insertion.state.punctures, 1);
  EXPECT_LT(insertion.state.entry_force, 1e-3);
  EXPECT_NEAR(insertion.state.tip_force, 0.164, 1e-6);
  EXPECT_GT(insertion.state.inserted, 0.012);
  insertion.move_to(-0.004);
  EXPECT_EQ(insertion.state.phase, NeedlePhase::kOutside);
  EXPECT_EQ(norm(insertion.state.force), 0);
}

// Nor does the far surface.
TEST(NeedleLeastToughness, SoftExitIsTorn) {
  const NeedleBlock sheet = make_block(0.06, 0.008, 0.004, Held::kSides, 2, {}, 8e4);
  Insertion insertion =
      above(sheet, {.toughness = 60, .entry_toughness = 300, .exit_toughness = 0}, 0.2, 0.7);
  insertion.move_to(0.016);
  EXPECT_TRUE(insertion.state.tracks[std::size_t(insertion.state.track)].is_through);
  insertion.move_to(-0.004);
  EXPECT_EQ(insertion.state.phase, NeedlePhase::kOutside);
  EXPECT_EQ(norm(insertion.state.force), 0);
}

// A lattice without toughness, with and without that of its surface.
TEST(NeedleLeastToughness, LatticeMeetsFrictionOnly) {
  for (const double entry : {200.0, 0.0}) {
    LatticeNeedleBlock block = firm_block();
    const Needle needle{.toughness = 0, .entry_toughness = entry};
    NeedlePush push(block, needle, 0.2, 0.5);
    double cutting = 0;
    push.move_to(kDeep, 2.5e-4, [&] {
      if (push.depth() > 0.015) cutting = std::max(cutting, push.state.tip_force);
    });
    const double inserted = push.state.inserted;
    EXPECT_NEAR(inserted, kDeep, 1e-3);
    EXPECT_LT(cutting, 1e-3);
    EXPECT_NEAR(push.force(), force_without_tearing(needle, inserted), 0.05 * push.force());
    EXPECT_EQ(push.state.punctures, 1);
    push.move_to(-0.004);
    EXPECT_EQ(push.state.phase, NeedlePhase::kOutside);
    EXPECT_EQ(norm(push.state.force), 0);
  }
}

// A lattice whose surface alone, or whose far surface alone, does not resist.
TEST(NeedleLeastToughness, LatticeSurfacesAreTorn) {
  LatticeNeedleBlock sheet{.size = {10, 10, 4}, .spacing = 0.004, .young = 8e4, .are_sides_fixed = true};
  for (const std::array<double, 2> surfaces : {std::array{0.0, 150.0}, {200.0, 0.0}}) {
    NeedlePush push(
        sheet,
        {.toughness = 60, .entry_toughness = surfaces[0], .exit_toughness = surfaces[1], .spreading = 2e4},
        0.1, 0.7);
    push.move_to(0.006, 1e-4);
    EXPECT_NEAR(push.state.tip_force, 0.06, 1e-6);
    push.move_to(0.02, 1e-4);
    EXPECT_TRUE(push.state.tracks[std::size_t(push.state.track)].is_through);
    EXPECT_EQ(push.state.punctures, 1);
    push.move_to(-0.004, 1e-4);
    EXPECT_EQ(norm(push.state.force), 0);
  }
}

}  // namespace
}  // namespace turgor::contact
