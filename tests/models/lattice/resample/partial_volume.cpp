// Partial volume of the skin in a deformed CT: it moves with the skin, and the surroundings stay.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(1);

// The deformed CT of a blurred body at rest equals its CT bit for bit.
TEST(PartialVolume, BodyAtRestEqualsCt) {
  for (const Int3 block : {Int3{1, 1, 1}, {2, 2, 2}, {4, 4, 4}, {3, 5, 2}}) {
    const CtVolume ct = blurred_ball_ct(33, 11.3, true);
    const Model model = body_of(ct, block);
    EXPECT_TRUE(resample_ct(kExec, model, make_state(model), ct, ct.grid).ct.samples == ct.samples)
        << block.x << " " << block.y << " " << block.z;
  }
}

// A displacement by whole voxels moves the blur of the skin too.
TEST(PartialVolume, BlurMovesWithSkin) {
  for (const int block : {1, 2, 3, 4, 5})
    for (const Int3 by : {Int3{3, -5, 2}, {0, 0, -1}, {-7, 6, 4}}) {
      const CtVolume ct = blurred_ball_ct(48, 14.4, false);
      const Model model = body_of(ct, {block, block, block});
      State state = make_state(model);
      move(model, state, [&](Vec3d) { return Vec3d(by) * kVoxel; });
      const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
      long wrong = 0;
      for_voxels(ct.grid, [&](Int3 p) { wrong += at_or_air(result.ct, p) != at_or_air(ct, p - by); });
      EXPECT_EQ(wrong, 0) << "block " << block;
    }
}

// The surroundings stay when the skin moves.
TEST(PartialVolume, SurroundingsStay) {
  CtVolume ct = blurred_ball_ct(48, 12.4, true);
  for_voxels(ct.grid, [&](Int3 p) {  // a table
    if (p.y > 38 && p.y < 42) ct.at(p.x, p.y, p.z) = std::int16_t(-300 + p.x);
  });
  const Model model = body_of(ct, {2, 2, 2});
  for (const Vec3d by : {Vec3d{0, -0.0025, 0}, {0.004, 0, 0.0015}}) {
    State state = make_state(model);
    move(model, state, [&](Vec3d) { return by; });
    const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
    long wrong = 0;
    for_voxels(ct.grid,
               [&](Int3 p) { wrong += p.y > 38 && result.ct.at(p.x, p.y, p.z) != ct.at(p.x, p.y, p.z); });
    EXPECT_EQ(wrong, 0);
  }
}

// A thin cover three voxels from slowly moving skin either stays or moves with it.
TEST(PartialVolume, ThinCoverStaysOrMovesWithSkin) {
  CtVolume ct = blurred_ball_ct(48, 12.4, false);
  for_voxels(ct.grid, [&](Int3 p) {  // a table whose cover is no denser than blurred skin
    if (p.y >= 39 && p.y < 42) ct.at(p.x, p.y, p.z) = p.y == 39 ? -600 : -150;
  });
  const Model model = body_of(ct, {2, 2, 2});
  for (const double by : {0.3, -0.4, -0.9}) {  // voxels, toward the table and away from it
    State state = make_state(model);
    move(model, state, [&](Vec3d) { return Vec3d{0, by * kVoxel, 0}; });
    const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
    long wrong = 0, moved_along = 0;
    for_voxels(ct.grid, [&](Int3 p) {
      if (p.y != 39) return;
      const double from = ct.at(p.x, p.y + (by < 0 ? 1 : -1), p.z), stayed = ct.at(p.x, p.y, p.z),
                   moved = stayed + std::abs(by) * (from - stayed);
      const double found = result.ct.at(p.x, p.y, p.z);
      moved_along += std::abs(found - moved) < 2;
      wrong += std::abs(found - stayed) > 0 && std::abs(found - moved) >= 2;
    });
    EXPECT_EQ(wrong, 0) << by << " voxels";
    EXPECT_LT(moved_along, 200) << "of 2304: near the ball's top";
  }
}

// The opening of a wound is air without a film of skin.
TEST(PartialVolume, WoundOpeningIsAir) {
  // A block whose top is blurred over three voxels, cut and pulled open to both sides.
  CtVolume ct = make_ct({48, 64, 40}, [](Vec3d p) { return p.z < 28; });
  const std::int16_t blur[] = {-150, -420, -650, -820, -930};
  for (const int block : {2, 4})
    for (const int first : {26, 27, 28}) {
      for_voxels(ct.grid, [&](Int3 p) {
        if (p.z >= first) ct.at(p.x, p.y, p.z) = p.z < first + 5 ? blur[p.z - first] : kAirHu;
      });
      const Model model = body_of(ct, {block, block, block});
      State state = make_state(model);
      const double at = 0.0313;
      cut_across_y(model, state, at, [](Vec3d) { return true; });
      move(model, state, [&](Vec3d p) { return Vec3d{0, p.y >= at ? 0.006 : -0.006, 0}; });
      const ResampledCt result = resample_ct(kExec, model, state, ct, ct.grid);
      long film = 0, skin = 0;
      for_voxels(ct.grid, [&](Int3 p) {
        const int aside = p.y < 31 ? 30 - p.y : p.y - 31;  // the lips are 6 voxels away
        if (aside < 3) film += result.ct.at(p.x, p.y, p.z) > kAirHu;
        const Int3 before{p.x, p.y < 31 ? p.y + 6 : p.y - 6, p.z};
        if (aside > 8 && aside < 20 && p.z >= first)
          skin += result.ct.at(p.x, p.y, p.z) != ct.at(before.x, before.y, before.z);
      });
      EXPECT_EQ(film, 0) << "blocks of " << block << ", blurred from " << first;
      EXPECT_EQ(skin, 0) << "blocks of " << block << ", blurred from " << first;
    }
}

}  // namespace
}  // namespace turgor::lattice
