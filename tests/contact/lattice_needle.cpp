#include "turgor/contact/lattice_needle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/contact/needle_push.hpp"
#include "turgor/core/hash.hpp"

namespace turgor::contact {
namespace {

using test_needles::firm_block;
using test_needles::NeedlePush;
using LatticeBlock = test_needles::LatticeNeedleBlock;

// The surface holds the tip until its force is the surface's toughness times the needle's width; then the
// force drops, and friction rises with depth.
TEST(LatticeNeedle, PunctureIsAPeakThenADrop) {
  LatticeBlock block = firm_block();
  const Needle needle{.toughness = 90, .entry_toughness = 210, .spreading = 0};
  NeedlePush push(block, needle, 0.2, 0.5);
  double peak = 0, after = 1;
  push.move_to(0.02, 2.5e-4, [&] {
    if (push.state.punctures == 0) peak = std::max(peak, push.force());
    if (push.state.inserted > 0.006) after = std::min(after, push.force());
  });
  EXPECT_EQ(push.state.punctures, 1);
  EXPECT_NEAR(push.state.entry_force, 0.21, 1e-9);
  EXPECT_NEAR(peak, 0.21, 0.02);
  EXPECT_LT(after, 0.6 * peak);
}

// Two insertions into one hole: the difference of their forces is J w. Spacings, widths and directions that
// are not those of the lattice. Work: that of the hand is accounted for.
TEST(LatticeNeedle, DoubleInsertionRecoversToughness) {
  struct Case {
    double spacing, toughness, diameter, tilt, around;
    Int3 size;
  };
  for (const Case c :
       {Case{0.004, 100, 0.001, 0.3, -0.8, {15, 15, 11}}, {0.006, 55, 0.0016, 0.45, 1.9, {12, 12, 9}}}) {
    LatticeBlock block = firm_block(c.spacing, c.size);
    const Needle needle{
        .diameter = c.diameter, .toughness = c.toughness, .entry_toughness = 1.5 * c.toughness};
    NeedlePush push(block, needle, c.tilt, c.around);
    std::array<double, 2> mean{};
    for (double& force : mean) {
      int frames = 0;
      push.move_to(0.024, 2.5e-4, [&] {
        if (push.depth() > 0.015 && push.depth() < 0.023) force += push.force(), frames++;
      });
      force /= frames;
      EXPECT_NEAR(push.energy_error(), 0, 0.03);
      push.move_to(-0.004);
      EXPECT_EQ(push.state.phase, NeedlePhase::kOutside);
      EXPECT_EQ(norm(push.state.force), 0);
    }
    EXPECT_EQ(push.state.punctures, 1);
    EXPECT_NEAR((mean[0] - mean[1]) / c.diameter, c.toughness, 0.05 * c.toughness);
  }
}

// In an old track without spreading, slip is all that resists: the force is f times the length in the tissue,
// both ways. Beyond the end of the track the needle tears again.
TEST(LatticeNeedle, FrictionIsProportionalToLength) {
  LatticeBlock block = firm_block();
  const Needle needle{.toughness = 60, .entry_toughness = 90, .friction = 2.3, .spreading = 0};
  NeedlePush push(block, needle, 0.25, 2.2);
  push.move_to(0.02, 5e-4);
  push.move_to(-0.004, 5e-4);
  // the last frames are short, because a frame has the length of the one before
  push.move_to(0.015, 5e-4), push.move_to(0.0155, 2.5e-5);
  EXPECT_NEAR(push.force(), needle.friction * push.state.inserted, 0.01 * push.force());
  EXPECT_EQ(push.state.tip_force, 0);
  push.move_to(0.008, 5e-4), push.move_to(0.0075, 2.5e-5);
  EXPECT_NEAR(push.force(), -needle.friction * push.state.inserted, 0.01 * std::abs(push.force()));
  push.move_to(0.024, 5e-4);
  EXPECT_NEAR(push.state.tip_force, 0.06, 1e-9);
}

// A needle that the hand holds still keeps its force and its depth: friction sticks. At the bound on a
// frame's drift, the force changes by less than 1e-5 in a minute; `turgor validate surgery` holds it that
// long.
TEST(LatticeNeedle, HeldNeedleDoesNotCreep) {
  LatticeBlock block = firm_block();
  NeedlePush push(block, {.toughness = 60, .entry_toughness = 90}, 0.2, 0.3);
  push.move_to(0.02);
  push.move_to(0.0192);  // some points stick, some slip
  push.hold(80);
  const Vec3d first = push.state.force;
  const double inserted = push.state.inserted;
  constexpr double kMinute = 60 * 60;  // frames
  push.hold(200);
  EXPECT_LT(norm(push.state.force - first), 1e-5 * 200 / kMinute * norm(first));
  EXPECT_NEAR(push.state.inserted, inserted, 1e-9);
  EXPECT_TRUE(push.state.settled);
}

// Far from its ends, a needle through a long block whose sides are held is a wire in antiplane shear: 2π G/
// ln(1.0787 b/a) per length, between a square of half width b and a wire of radius a.
TEST(LatticeNeedle, PulledShaftHasStiffnessOfWire) {
  LatticeBlock block{
      .size = {9, 9, 21}, .spacing = 0.006, .young = 1e4, .are_sides_fixed = true, .sweeps = 20};
  NeedlePush push(block, {.length = 0.15,
                          .diameter = 0.0009,
                          .toughness = 5,
                          .entry_toughness = 5,
                          .friction = 0,
                          .spreading = 0});
  push.move_to(0.118, 1e-3);
  push.needle.friction = 1e9;
  push.hold(5);
  push.move_to(push.depth() + 1e-4, 1e-5);
  push.hold(60);
  const LatticeNeedleTrack& track = push.state.tracks[std::size_t(push.state.track)];
  double force = 0, engaged = 0;
  for (std::size_t i = 1; i < track.points.size(); i++)
    if (track.points[i].arc > 0.04 && track.points[i].arc < 0.08)
      force -= track.points[i].force.z, engaged += track.points[i].engaged;
  const double width = 8 * block.spacing, shear = block.young / (2 * (1 + block.poisson));
  const double expected = 2 * std::numbers::pi * shear / std::log(1.0787 * width / push.needle.diameter);
  EXPECT_NEAR(force / 1e-4 / engaged / expected, 1, 0.1);
}

// The same bits on any number of threads.
TEST(LatticeNeedle, ThreadsKeepBits) {
  std::array<std::uint64_t, 3> hash{};
  for (std::size_t n = 0; n < 3; n++) {
    LatticeBlock block = firm_block(0.006, {11, 11, 8});
    block.threads = n == 0 ? 1 : n == 1 ? 2 : 8;
    NeedlePush push(block, {.toughness = 60, .entry_toughness = 90}, 0.3, 0.3);
    push.move_to(0.012, 5e-4);
    push.move_to(-0.003, 1e-3);
    push.move_to(0.01, 1e-3);
    hash[n] =
        hash_bytes(&push.state.force, sizeof push.state.force, lattice::state_hash(block.model, block.state));
  }
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_EQ(hash[0], hash[2]);
}

// A haptic tick at the frame's pose has the frame's force. Pushed further, the force stays at that which
// cuts. Pulled back, it falls to friction against the hand. The ticks return no energy.
TEST(LatticeNeedle, TicksStayBetweenFrictionAndCutting) {
  LatticeBlock block = firm_block();
  const Needle needle{.toughness = 60, .entry_toughness = 90, .friction = 3, .spreading = 0};
  NeedlePush push(block, needle, 0.1, 0.3);
  push.move_to(0.02);
  const LocalContact contact = local_contact(block.model, needle, push.state);
  LocalTouch touch{.params = {.damping = 0}};
  update_contact(touch, contact);
  const Vec3d up = push.pose.axes.column[2];
  const auto force_at = [&](double deeper) {
    ToolReading reading;
    tick_local_touch(touch, {.pose = {push.pose.position - up * deeper, push.pose.axes}}, 1e-3, reading);
    return dot(reading.force, up);
  };
  EXPECT_NEAR(force_at(0), push.force(), 1e-9);
  const double friction = needle.friction * push.state.inserted;
  const double one_point = needle.friction * needle.spacing;
  EXPECT_NEAR(force_at(0.003), friction + 0.06, one_point);
  EXPECT_NEAR(force_at(-0.02), -friction, one_point);
  EXPECT_GT(force_at(-0.019), -friction);
  // a closed path
  double work = 0, before = force_at(0), at = 0;
  for (int i = 1; i <= 2000; i++) {
    const double next = 0.004 * std::sin(2 * std::numbers::pi * i / 1000), force = force_at(next);
    work += 0.5 * (before + force) * (next - at);
    before = force, at = next;
  }
  EXPECT_GT(work, 0);
}

// A tip on the surface that the hand pushes on between two frames: the force rises to the surface's toughness
// times the width and drops to that of the tissue in the tick that punctures. Withdrawn below that force, the
// tip stays on the surface.
TEST(LatticeNeedle, PunctureIsFeltWithinFrame) {
  LatticeBlock block = firm_block();
  const Needle needle{.toughness = 70, .entry_toughness = 190, .spreading = 0};
  NeedlePush push(block, needle, 0.15, 1.1);
  for (int frame = 0; frame < 40 && push.force() < 0.1; frame++) push.move_to(push.depth() + 2.5e-4);
  ASSERT_EQ(push.state.phase, NeedlePhase::kTouching);
  LocalTouch touch{.params = {.damping = 0}};
  update_contact(touch, local_contact(block.model, needle, push.state));
  const Vec3d up = push.pose.axes.column[2];
  const auto force_at = [&](double deeper) {
    ToolReading reading;
    tick_local_touch(touch, {.pose = {push.pose.position - up * deeper, push.pose.axes}}, 1e-3, reading);
    return dot(reading.force, up);
  };
  EXPECT_GT(force_at(1e-5), force_at(0));
  double peak = 0, after = 0;
  for (int tick = 1; tick <= 16 && after == 0; tick++) {
    const double force = force_at(1e-4 * tick);
    (force < peak ? after : peak) = force;
  }
  EXPECT_NEAR(after, 0.07, 1e-9);
  EXPECT_LE(peak, 0.19);
  EXPECT_GT(peak, 0.15);
  // pushed on, it cuts at that force
  EXPECT_NEAR(force_at(0.002), 0.07, 1e-9);
}

}  // namespace
}  // namespace turgor::contact
