// Cuts and stitches by a program: names, curves and refusals. The C interface tests bits and pulls.
#include "turgor/sim/live/by_hand.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "tests/sim/resumed.hpp"

namespace turgor {
namespace {

const Exec kHandThread(1);
constexpr BodyId kOnlyLattice{BodyKind::kLattice, 0};

/// Line beside the cut of the scene.
CutByHand line_at(double x) {
  return {.body = kOnlyLattice, .name = {}, .points = {{x, -0.02, -0.03}, {x, -0.02, 0.03}}, .depth = 0.012};
}

std::string reason_of(const Result<std::string>& made) { return made ? "" : made.error().message; }

// Names of new wounds avoid those of the world, a curve through three points bends, and a stitch finds a
// wound by its name.
TEST(ByHand, NamesWoundsAndStitches) {
  auto scene = std::make_shared<const Scene>(
      test::block_scene(test::fresh_folder(), {"world.duration=2", "incision.cut.duration=0"}));
  World world = test::block_world(kHandThread, *scene);
  CutByHand named = line_at(-0.03);
  named.name = "hand-1", named.points.insert(named.points.begin() + 1, {-0.036, -0.02, 0});
  EXPECT_EQ(cut_by_hand(kHandThread, named, scene, world).value(), "hand-1");
  EXPECT_EQ(world.cuts[1].blade.path.size(), 3u);
  EXPECT_EQ(cut_by_hand(kHandThread, line_at(0.03), scene, world).value(), "hand-2");
  EXPECT_EQ(world.cuts[2].blade.start, 0);
  test::step_frames(world, 15);
  StitchByHand stitch{.body = kOnlyLattice,
                      .wound = "hand-2",
                      .points = {{0.018, -0.019, 0.004},
                                 {0.018, -0.015, 0.004},
                                 {0.042, -0.015, 0.004},
                                 {0.042, -0.019, 0.004}},
                      .tension = {}};
  EXPECT_EQ(stitch_by_hand(kHandThread, stitch, scene, world).value(), "hand-1");
  EXPECT_EQ(world.sutures[0].scene.incision, 2);
  stitch.wound = "hand-3";
  EXPECT_EQ(reason_of(stitch_by_hand(kHandThread, stitch, scene, world)),
            "no stitch: the world has no wound hand-3; did you mean hand-1?");
}

// A state file keeps cuts and stitches by hand: a blade in motion, a stitch that is pulled and one that was
// tightened. A fresh world of the scene continues with the same bits, and its stitches can be tightened.
TEST(ByHand, StateFileKeepsCutsAndStitches) {
  const std::filesystem::path folder = test::fresh_folder();
  auto scene = std::make_shared<const Scene>(
      test::block_scene(folder, {"world.duration=2", "incision.cut.duration=0"}));
  World world = test::block_world(kHandThread, *scene), resumed = test::block_world(kHandThread, *scene);
  const LoadedPatches loaded = loaded_patches(world);
  ASSERT_TRUE(cut_by_hand(kHandThread, line_at(0.03), scene, world));
  test::step_frames(world, 15);
  const auto stitch_at = [](double z) {
    return StitchByHand{
        .body = kOnlyLattice,
        .wound = "hand-1",
        .points = {{0.018, -0.019, z}, {0.018, -0.015, z}, {0.042, -0.015, z}, {0.042, -0.019, z}},
        .tension = {}};
  };
  ASSERT_TRUE(stitch_by_hand(kHandThread, stitch_at(0.004), scene, world));
  ASSERT_TRUE(stitch_by_hand(kHandThread, stitch_at(-0.012), scene, world));
  test::step_frames(world, 6);
  ASSERT_TRUE(tighten_by_hand(kHandThread, "hand-2", 0.3, 0.2, scene, world));
  CutByHand curve = line_at(-0.03);
  curve.name = "curve", curve.points.insert(curve.points.begin() + 1, {-0.036, -0.02, 0});
  ASSERT_TRUE(cut_by_hand(kHandThread, curve, scene, world));
  test::step_frames(world, 3);
  ASSERT_GT(world.cuts[2].done, 0);
  ASSERT_LT(world.cuts[2].done, 1);
  test::expect_resumes(kHandThread, folder / "state", loaded, world, resumed);
  ASSERT_EQ(resumed.cuts.size(), 3u);
  EXPECT_EQ(resumed.cuts[2].blade.name, "curve");
  ASSERT_EQ(resumed.sutures.size(), 2u);
  EXPECT_GT(resumed.sutures[1].closure->stitches[0].tension, 0);
  for (World* one : {&world, &resumed}) {
    ASSERT_TRUE(tighten_by_hand(kHandThread, "hand-1", 0.5, 0.1, scene, *one));
    test::step_frames(*one, 8);
  }
  EXPECT_EQ(state_hash(world), state_hash(resumed));
  EXPECT_EQ(world.sutures[0].closure->stitches[0].tension, resumed.sutures[0].closure->stitches[0].tension);
}

// Bodies without cuts, taken names and numbers out of range are refused with what was found.
TEST(ByHand, RefusesWithReason) {
  auto scene = std::make_shared<const Scene>(test::block_scene(test::fresh_folder()));
  World world = test::block_world(kHandThread, *scene);
  const auto refused = [&](const CutByHand& cut) {
    return reason_of(cut_by_hand(kHandThread, cut, scene, world));
  };
  CutByHand cut = line_at(0.03);
  cut.body = {BodyKind::kSfem, 0};
  EXPECT_EQ(refused(cut),
            "no cut: expected a body with model = \"lattice\", found one with model = \"sfem\"");
  cut = line_at(0.03), cut.name = "cut";
  EXPECT_EQ(refused(cut), "no cut: expected a name of its own, found that of another wound, cut");
  cut = line_at(0.03), cut.tilt = 80;
  EXPECT_EQ(refused(cut), "no cut: expected a tilt from -75 to 75 degrees, found 80");
  cut = line_at(0.03), cut.duration = -1;
  EXPECT_EQ(refused(cut), "no cut: expected a duration from 0 to 3600 s, found -1");
  cut = line_at(0.03), cut.points[1] = cut.points[0];
  EXPECT_NE(refused(cut).find("consecutive ones distinct"), std::string::npos);
  cut = line_at(0.03), cut.points[1].x = 1e9;
  EXPECT_NE(refused(cut).find("within 100 m"), std::string::npos);
  for (int axis = 0; axis < 3; axis++) {
    cut = line_at(0.03), cut.points[1][axis] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(refused(cut).find("within 100 m"), std::string::npos) << "axis " << axis;
  }
  EXPECT_EQ(world.cuts.size(), 1u);
  EXPECT_FALSE(tighten_by_hand(kHandThread, "row", 1.0, 0.1, scene, world));
}

}  // namespace
}  // namespace turgor
