#include "turgor/contact/needle_touch.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/contact/needle_insertion.hpp"

namespace turgor::contact {
namespace {

using test_needles::above;
using test_needles::Held;
using test_needles::Insertion;
using test_needles::make_block;
using test_needles::NeedleBlock;
using test_needles::soft_block;
using test_needles::tilted_axes;

// The surface holds the tip until the force reaches its toughness times the needle's width; then the force
// drops to what the tissue inside resists.
TEST(NeedleTouch, PunctureIsAPeakThenADrop) {
  const Needle needle{
      .diameter = 0.0012, .toughness = 150, .entry_toughness = 400, .friction = 1, .spreading = 2e4};
  Insertion insertion = above(soft_block(), needle, 0.2, 0.5);
  double peak = 0, after = 1e9;
  insertion.move_to(0.025, 4e-5, [&](double, double force) {
    if (insertion.state.punctures == 0) peak = std::max(peak, force);
    if (insertion.state.inserted > 0.004) after = std::min(after, force);
  });
  EXPECT_EQ(insertion.state.punctures, 1);
  EXPECT_NEAR(insertion.state.entry_force, 400 * 0.0012, 1e-9);
  EXPECT_NEAR(peak, 400 * 0.0012, 0.01);
  EXPECT_LT(after, 0.6 * peak);
}

// Two insertions into one hole: the difference of their forces is J w. Three sizes and directions.
TEST(NeedleTouch, DoubleInsertionRecoversToughness) {
  struct Case {
    double toughness, diameter, tilt, around;
  };
  for (const Case c : {Case{164, 0.001, 0, 0}, {90, 0.0018, 0.3, 1.9}, {260, 0.0006, 0.45, -0.8}}) {
    const Needle needle{
        .diameter = c.diameter, .toughness = c.toughness, .entry_toughness = 1.5 * c.toughness};
    Insertion insertion = above(soft_block(), needle, c.tilt, c.around);
    std::array<double, 2> work{}, length{};
    for (std::size_t pass = 0; pass < 2; pass++) {
      double before = 0;
      insertion.move_to(0.03, 4e-5, [&](double depth, double force) {
        if (depth > 0.015 && depth < 0.025)
          work[pass] += force * (depth - before), length[pass] += depth - before;
        before = depth;
      });
      insertion.move_to(-0.001);
      EXPECT_EQ(insertion.state.phase, NeedlePhase::kOutside);
    }
    const double found = (work[0] / length[0] - work[1] / length[1]) / c.diameter;
    EXPECT_NEAR(found, c.toughness, 0.05 * c.toughness);
  }
}

// Insertion, withdrawal, and both again: the hand's work is cutting, friction, and what is stored.
TEST(NeedleTouch, WorkOfHandIsAccountedFor) {
  for (const double tilt : {0.0, 0.4}) {
    Insertion insertion = above(soft_block(), {.diameter = 0.001}, tilt, 0.9);
    for (int pass = 0; pass < 2; pass++) {
      insertion.move_to(0.03);
      EXPECT_NEAR(insertion.energy_error(), 0, 0.01);
      insertion.move_to(-0.001);
      EXPECT_NEAR(insertion.energy_error(), 0, 0.01);
      EXPECT_LT(std::abs(insertion.state.work.elastic + insertion.state.work.spreading), 1e-12);
    }
    EXPECT_GT(insertion.state.work.friction, 0);
  }
}

// A needle that the hand holds still keeps its force: friction sticks. `turgor validate surgery` holds it for
// a minute.
TEST(NeedleTouch, HeldNeedleDoesNotCreep) {
  Insertion insertion = above(soft_block(), {.diameter = 0.001}, 0.2, 0.3);
  insertion.move_to(0.03);
  insertion.move_to(0.029);
  insertion.move_to(0.0293);  // some points stick, some slip
  const auto hold = [&](int ticks) {
    for (int i = 0; i < ticks; i++)
      tick_needle(insertion.block.inner, insertion.needle, {}, insertion.pose, 1, insertion.state);
  };
  hold(200);
  const Vec3d first = insertion.state.force;
  const double inserted = insertion.state.inserted;
  hold(10000);
  EXPECT_LT(norm(insertion.state.force - first), 1e-6 * norm(first));
  EXPECT_NEAR(insertion.state.inserted, inserted, 1e-9);
}

// The forces of a tick are unique: the start that it takes from earlier ticks changes them by less than its
// tolerance, also where the hand turns back.
TEST(NeedleTouch, ForcesDoNotDependOnTheirStart) {
  const Needle needle{.diameter = 0.001};
  Insertion insertion = above(soft_block(), needle, 0.2, 0.3), other = insertion;
  std::vector<Vec3d> forces;
  double largest = 0, difference = 0;
  const auto strokes = [](Insertion& in, const auto& visit) {
    for (const double depth : {0.03, 0.026, 0.029, 0.012, 0.025}) in.move_to(depth, 1e-4, visit);
  };
  strokes(insertion, [&](double, double) { forces.push_back(insertion.state.force); });
  std::size_t n = 0;
  strokes(other, [&](double, double) {
    other.state.step = {};  // starts from the forces of the last tick
    largest = std::max(largest, norm(forces[n]));
    difference = std::max(difference, norm(other.state.force - forces[n++]));
  });
  EXPECT_LT(difference, 1e-4 * largest) << "N";
}

// A needle through a long block whose sides are held, pulled along its axis: far from the ends it is
// antiplane shear, k = 2π G/ln(1.0787 b/a) per length between a square of half width b and a wire of radius
// a, wherever the wire passes between the nodes of the mesh.
TEST(NeedleTouch, PulledShaftHasStiffnessOfWire) {
  const double width = 0.048, length = 0.12;
  for (const double edge : {0.012})  // turgor validate surgery has finer meshes
    for (const Vec3d offset : {Vec3d{}, Vec3d{0.5, 0.5, 0}, Vec3d{0.25, 0.6, 0}}) {
      const Vec3d entry = Vec3d{width / 2, width / 2, length} + offset * edge;
      const NeedleBlock block = make_block(width, length, edge, Held::kSides, 2, entry);
      const double diameter = offset.x > 0 ? 0.0006 : 0.0009;
      Insertion insertion = above(block, {.length = 0.15,
                                          .diameter = diameter,
                                          .toughness = 1e-3,
                                          .entry_toughness = 1e-3,
                                          .exit_toughness = 1e-3,
                                          .friction = 0,
                                          .spreading = 0});
      insertion.entry = entry, insertion.pose.position = entry + Vec3d{0, 0, 0.001};
      insertion.move_to(length + 0.004, 1e-4);
      const NeedleTrack& track = insertion.state.tracks[std::size_t(insertion.state.track)];
      ASSERT_TRUE(track.is_through);
      insertion.needle.friction = 1e9;
      insertion.move_to(insertion.depth() + 1e-5, 1e-6);
      double force = 0, engaged = 0;
      for (std::size_t i = 1; i < track.points.size(); i++)
        if (track.points[i].arc > length / 3 && track.points[i].arc < 2 * length / 3)
          force -= track.force[i].z, engaged += track.points[i].engaged;
      const double expected = 2 * std::numbers::pi * block.young / 2.9 / std::log(1.0787 * width / diameter);
      EXPECT_NEAR(force / 1e-5 / engaged / expected, 1, 0.1) << edge << ' ' << offset.x;
    }
}

// A second needle position away from the first hole tears again; in the hole nothing tears.
TEST(NeedleTouch, OnlyOldTrackIsFree) {
  Insertion insertion = above(soft_block(), {.diameter = 0.001, .friction = 0, .spreading = 0});
  insertion.move_to(0.02);
  EXPECT_NEAR(insertion.state.tip_force, 0.164, 0.17 * 0.164);
  insertion.move_to(-0.001);
  insertion.move_to(0.012);
  EXPECT_EQ(insertion.state.tip_force, 0);
  EXPECT_EQ(insertion.state.punctures, 1);
  insertion.move_to(-0.001);
  insertion.pose.position.x += 0.006, insertion.entry.x += 0.006;
  insertion.move_to(0.012);
  EXPECT_NEAR(insertion.state.tip_force, 0.164, 1e-6);
  EXPECT_EQ(insertion.state.punctures, 2);
}

// Deeper layers with a toughness of their own resist with it: the force rises at the border.
TEST(NeedleTouch, LayersHaveTheirToughness) {
  NeedleBlock block = soft_block();
  for (std::size_t e = 0; e < block.inner.elements.size(); e++) {
    const Vec3d corner = block.inner.x[std::size_t(block.inner.corner[e * std::size_t(block.inner.corners)])];
    block.inner.toughness.push_back(corner.z < 0.029 ? 350 : -1);  // a corner at the bottom of an element
  }
  Insertion insertion = above(block, {.diameter = 0.001, .friction = 0, .spreading = 0});
  insertion.move_to(0.018);
  EXPECT_NEAR(insertion.state.tip_force, 0.164, 1e-9);
  insertion.move_to(0.035);
  EXPECT_NEAR(insertion.state.tip_force, 0.35, 1e-9);
}

// A needle that is turned in the tissue feels a force across it and a torque that turns it back.
TEST(NeedleTouch, TiltedNeedleIsTurnedBack) {
  Insertion insertion = above(soft_block(), {.diameter = 0.001});
  insertion.move_to(0.03);
  const Vec3d before = insertion.state.torque;
  const Mat3d axes = tilted_axes(0.05, 0);  // the shaft leans toward x
  Pose pose = insertion.pose;
  pose.axes = axes;
  for (int i = 0; i < 50; i++)
    tick_needle(insertion.block.inner, insertion.needle, {}, pose, 1, insertion.state);
  const Vec3d turn = cross(insertion.pose.axes.column[2], axes.column[2]);
  EXPECT_LT(dot(insertion.state.torque - before, turn), 0);
  EXPECT_LT(insertion.state.force.x, 0);
}

// The state, and so every force, is the same on any number of threads, and a tick allocates nothing.
TEST(NeedleTouch, TicksAllocateNothingAndKeepBits) {
  std::array<Vec3d, 2> forces;
  for (int n = 0; n < 2; n++) {
    const NeedleBlock block = make_block(0.06, 0.05, 0.01, Held::kBottom, n == 0 ? 1 : 8);
    Insertion insertion = above(block, {.diameter = 0.001}, 0.3, 0.3);
    EXPECT_EQ(test::allocations_of([&] {
                insertion.move_to(0.03, 2e-4);
                insertion.move_to(-0.001, 2e-4);
                insertion.move_to(0.02, 2e-4);
              }),
              0u);
    forces[std::size_t(n)] = insertion.state.force;
  }
  EXPECT_EQ(forces[0], forces[1]);
}

}  // namespace
}  // namespace turgor::contact
