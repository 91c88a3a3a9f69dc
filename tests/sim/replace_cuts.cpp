// Cuts that are replaced in a loaded world.
#include "turgor/sim/replace_cuts.hpp"

#include "tests/sim/block_scene.hpp"

namespace turgor {
namespace {

// A world whose bodies are put back to rest and whose cuts are replaced steps as one that was loaded with
// these cuts.
TEST(ReplaceCuts, WorldStepsAsIfLoaded) {
  const std::filesystem::path folder = test::fresh_folder();
  const Exec exec(1);
  const Scene drawn = test::block_scene(folder),
              moved = test::block_scene(folder,
                                        {"incision.cut.to=[0.015, -0.02, 0.02]", "incision.cut.depth=0.02"});
  World world = test::block_world(exec, drawn), fresh = test::block_world(exec, moved);
  const std::vector<LatticeBody> at_rest = world.lattice_bodies;
  for (int frame = 0; frame < 8; frame++) ASSERT_TRUE(step(exec, world));
  const std::uint64_t first = state_hash(world);
  world.lattice_bodies = at_rest, world.frame = 0;
  ASSERT_TRUE(replace_cuts(moved, world));
  for (int frame = 0; frame < 8; frame++) ASSERT_TRUE(step(exec, world) && step(exec, fresh));
  EXPECT_EQ(state_hash(world), state_hash(fresh));
  EXPECT_NE(state_hash(world), first);
}

}  // namespace
}  // namespace turgor
