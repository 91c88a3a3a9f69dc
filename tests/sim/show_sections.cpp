#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {
namespace {

CutawayScene across_cut(std::optional<Vec3d> wedge = {}) {
  return {.body = {BodyKind::kLattice, 0},
          .by_fraction = false,
          .at = {0.002, 0, 0.001},
          .normal = {0, 0, 1},
          .wedge = wedge};
}

/// Value of a section at a point of its plane [HU].
int value_at(const CtVolume& section, Vec3d point) {
  const Vec3d index = index_at(section.grid, point);
  EXPECT_NEAR(index.z, 0, 1e-9) << "in the plane";
  return section.at(int(std::lround(index.x)), int(std::lround(index.y)), 0);
}

// A section shows the CT's values in the body, and air in the wound once it has opened.
TEST(ShowSections, SectionHasCtValuesAndWound) {
  const Exec exec(2);
  World world = test::block_world(
      exec, test::block_scene(test::fresh_folder(), {"body.block.skin.tension=60", "world.duration=0.6"}));
  WorldSnapshot snapshot;
  snapshot.cutaway = across_cut();
  const auto section = [&]() -> const CtVolume& {
    show(exec, world, snapshot);
    EXPECT_EQ(snapshot.bodies[0].sections.size(), 1u);
    return snapshot.bodies[0].sections[0];
  };
  const Vec3d in_wound{0.002, -0.0165, 0.001}, in_fat{0.03, 0, 0.001}, in_bone{0.03, 0.03, 0.001};
  const CtVolume before = section();
  EXPECT_EQ(value_at(before, in_fat), -100);
  EXPECT_EQ(value_at(before, in_bone), 1000);
  EXPECT_EQ(value_at(before, in_wound), -100);
  for (int frame = 0; frame < 30; frame++) ASSERT_TRUE(step(exec, world));
  const CtVolume after = section();
  EXPECT_EQ(value_at(after, in_bone), 1000);
  EXPECT_LT(value_at(after, in_wound), -500) << "air between the lips";
}

// A wedge has two sections. No cut-away, another body and a body of another world have none.
TEST(ShowSections, OnlyTheCutBodyHasSections) {
  const Exec exec(2);
  const World world = test::block_world(exec, test::block_scene(test::fresh_folder()));
  WorldSnapshot snapshot;
  const auto sections = [&](std::optional<CutawayScene> cutaway) {
    snapshot.cutaway = std::move(cutaway);
    show(exec, world, snapshot);
    return snapshot.bodies[0].sections.size();
  };
  EXPECT_EQ(sections(across_cut(Vec3d{1, 0, 0})), 2u);
  EXPECT_EQ(sections(std::nullopt), 0u);
  CutawayScene other = across_cut();
  other.body = {BodyKind::kSfem, 0};
  EXPECT_EQ(sections(other), 0u);
  other.body = {BodyKind::kLattice, 7};
  EXPECT_EQ(sections(other), 0u);
}

}  // namespace
}  // namespace turgor
