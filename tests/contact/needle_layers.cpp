// Needles through surfaces and thin layers: peaks of the force where they enter, pass a capsule and leave.
#include <algorithm>
#include <cmath>
#include <vector>

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

/// Maximum of a force that is followed by a drop of a tenth, and the minimum after it.
struct ForcePeak {
  double depth = 0, force = 0, after = 0;  // [m] [N]
};
struct ForcePeaks {
  std::vector<ForcePeak> all;
  ForcePeak highest = {};
  bool rises = true;

  void add(double depth, double force) {
    if (!rises) {
      all.back().after = std::min(all.back().after, force);
      rises = force > 1.1 * all.back().after + 0.01;
      if (rises) highest = {};
    }
    if (rises && force > highest.force) highest = {depth, force, force};
    if (rises && force < 0.9 * highest.force) all.push_back(highest), all.back().after = force, rises = false;
  }
};

// A sheet with tough surfaces: the force has a peak where the needle enters and one where it leaves. They are
// the surfaces' toughnesses times the diameter; at the exit, friction and the load of the spread crack come
// on top. The hand's work is accounted for, also of a second insertion, which meets no surface.
TEST(NeedleLayers, SheetHasPeaksOfEntryAndExit) {
  const double thickness = 0.008;
  const NeedleBlock sheet = make_block(0.06, thickness, 0.004, Held::kSides, 2, {}, 8e4);
  for (const double tilt : {0.0, 0.3}) {
    const Needle needle{
        .toughness = 60, .entry_toughness = 300, .exit_toughness = 200, .friction = 1.4, .spreading = 2e4};
    Insertion insertion = above(sheet, needle, tilt, 0.7);
    ForcePeaks peaks;
    insertion.move_to(0.016, 4e-5, [&](double depth, double force) { peaks.add(depth, force); });
    ASSERT_EQ(peaks.all.size(), 2u);
    EXPECT_NEAR(peaks.all[0].force, 0.3, 1e-3);
    EXPECT_LT(peaks.all[0].after, 0.09);
    const double passage = thickness / std::cos(tilt), others = spreading_force(needle, {passage, 0});
    EXPECT_NEAR(peaks.all[1].force, 0.2 + needle.friction * passage + others, 0.01);
    EXPECT_LT(peaks.all[1].after, 0.02);
    EXPECT_GT(peaks.all[1].depth, passage);
    EXPECT_TRUE(insertion.state.tracks[std::size_t(insertion.state.track)].is_through);
    EXPECT_NEAR(insertion.energy_error(), 0, 0.01);
    insertion.move_to(-0.002);
    double again = 0;
    insertion.move_to(0.016, 4e-5, [&](double, double force) { again = std::max(again, force); });
    EXPECT_LT(again, 0.04);
    EXPECT_NEAR(insertion.energy_error(), 0, 0.01);
  }
}

// The same of a lattice.
TEST(NeedleLayers, LatticeSheetHasPeaksOfEntryAndExit) {
  LatticeNeedleBlock sheet{.size = {10, 10, 4}, .spacing = 0.004, .young = 8e4, .are_sides_fixed = true};
  const Needle needle{.toughness = 60, .entry_toughness = 200, .exit_toughness = 150, .spreading = 2e4};
  NeedlePush push(sheet, needle, 0.1, 0.7);
  ForcePeaks peaks;
  push.move_to(0.02, 1e-4, [&] { peaks.add(push.depth(), push.force()); });
  ASSERT_EQ(peaks.all.size(), 2u);
  EXPECT_NEAR(peaks.all[0].force, 0.2, 1e-3);
  EXPECT_LT(peaks.all[0].after, 0.09);
  const double passage = push.state.tracks[0].length;
  EXPECT_NEAR(peaks.all[1].force, 0.15 + needle.friction * passage + spreading_force(needle, {passage, 0}),
              0.01);
  EXPECT_LT(peaks.all[1].after, 0.06);
  EXPECT_NEAR(push.energy_error(), 0, 0.01);
  push.move_to(-0.004, 5e-4);
  EXPECT_NEAR(push.energy_error(), 0, 0.02);
}

// A capsule inside of softer tissue: a peak at its toughness times the diameter, then a drop, in a block of
// finite elements and in a lattice. The second insertion meets none.
TEST(NeedleLayers, CapsuleIsAPeakThenADrop) {
  const double capsule = 0.3;  // force that tears it [N]
  const Needle needle{
      .toughness = 80, .entry_toughness = 100, .exit_toughness = 100, .friction = 0.5, .spreading = 0};
  // finite elements; the capsule has the height of one
  const double edge = 0.0025, width = 0.03, height = 0.02;
  NeedleBlock block =
      make_block(width, height, edge, Held::kBottom, 2, Vec3d{0.52 * width, 0.47 * width, height}, 4e4);
  for (std::size_t e = 0; e < block.inner.elements.size(); e++) {
    double z = 0;
    for (std::size_t c = 0; c < 8; c++) z += block.inner.x[std::size_t(block.inner.corner[8 * e + c])].z / 8;
    block.inner.toughness.push_back(std::abs(z - height + 3.5 * edge) < edge / 2 ? 300 : -1);
  }
  Insertion insertion = above(block, needle);
  ForcePeaks peaks;
  insertion.move_to(0.018, 4e-5, [&](double depth, double force) { peaks.add(depth, force); });
  ASSERT_EQ(peaks.all.size(), 2u);
  EXPECT_NEAR(peaks.all[1].force, capsule + needle.friction * 0.01, 0.01);
  EXPECT_LT(peaks.all[1].after, 0.1);
  EXPECT_NEAR(insertion.energy_error(), 0, 0.02);
  // lattice
  LatticeNeedleBlock cells{.size = {11, 11, 8}, .spacing = 0.003, .young = 4e4};
  NeedlePush push(cells, needle, 0.1, 0.3);
  const double top = cells.top();
  push.tissue_at = [top](Vec3d rest) {
    return NeedleTissue{.toughness = std::abs(top - rest.z - 0.007) < 0.0005 ? 300.0 : -1.0};
  };
  ForcePeaks in_cells;
  push.move_to(0.015, 1.5e-4, [&] { in_cells.add(push.depth(), push.force()); });
  ASSERT_EQ(in_cells.all.size(), 2u);
  EXPECT_NEAR(in_cells.all[1].force, capsule + needle.friction * 0.007, 0.01);
  EXPECT_LT(in_cells.all[1].after, 0.1);
  EXPECT_NEAR(push.energy_error(), 0, 0.03);
  push.move_to(-0.003, 1e-3);
  double again = 0;
  push.move_to(0.014, 5e-4, [&] { again = std::max(again, push.force()); });
  EXPECT_LT(again, 0.05);
}

// A tense skin dents less before it is punctured, so that the force at a depth rises with skin.tension. The
// force of the puncture is that of the toughness with any tension.
TEST(NeedleLayers, ForceAtDepthRisesWithSkinTension) {
  std::vector<double> at_depth, dent;
  for (const double tension : {10.0, 30.0, 60.0}) {
    LatticeNeedleBlock block = firm_block(0.004, {13, 13, 7});
    block.tension = tension;
    NeedlePush push(block, {.toughness = 90, .entry_toughness = 210, .spreading = 0});
    push.move_to(0.001, 1e-4);
    at_depth.push_back(push.force());
    push.move_to(0.006, 1e-4, [&] {
      if (push.state.punctures == 0) dent.resize(at_depth.size()), dent.back() = push.depth();
    });
    EXPECT_EQ(push.state.punctures, 1);
    EXPECT_NEAR(push.state.entry_force, 0.21, 1e-6) << "N";
  }
  for (std::size_t i = 1; i < 3; i++) {
    EXPECT_GT(at_depth[i], 1.2 * at_depth[i - 1]) << "N, 1 mm deep";
    EXPECT_LT(dent[i], 0.9 * dent[i - 1]) << "m";
  }
}

// A needle that is turned in a lattice feels a force across it and a torque that turns it back. Turned back
// itself, it has the first force again.
TEST(NeedleLayers, TurnedNeedleIsTurnedBackByLattice) {
  LatticeNeedleBlock block = firm_block();
  NeedlePush push(block, {.toughness = 60, .entry_toughness = 90});
  push.move_to(0.02, 5e-4);
  push.hold(20);
  const Mat3d upright = push.pose.axes;
  const Vec3d force = push.state.force, torque = push.state.torque;
  const Mat3d axes = test_needles::axes_at(0.05, 0);
  const Vec3d turn = cross(upright.column[2], axes.column[2]);
  push.pose.axes = axes;
  push.hold(30);
  EXPECT_LT(push.state.force.x, force.x - 0.02) << "N";
  EXPECT_NEAR(push.state.force.y, force.y, 0.002) << "N";
  EXPECT_LT(dot(push.state.torque - torque, turn), -1e-5);
  push.pose.axes = upright;
  push.hold(60);
  EXPECT_NEAR(push.state.force.x, force.x, 0.008) << "N: friction keeps some";
  EXPECT_NEAR(dot(push.state.torque - torque, turn), 0, 3e-6);
  EXPECT_NEAR(push.energy_error(), 0, 0.02);
}

}  // namespace
}  // namespace turgor::contact
