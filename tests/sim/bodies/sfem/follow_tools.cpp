#include "turgor/sim/bodies/sfem/follow_tools.hpp"

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

using test::body_scene;
using test::sfem_world;

// A new patch starts a fixed number of ticks after its request, and no tick is skipped.
TEST(FollowTools, NewPatchStartsAfterFixedTicks) {
  World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  SfemBody& body = world.sfem_bodies[0];
  touch_body(Exec(1), body, world.tools, 0, 0.1);  // pressed
  body.centers[0].x += 0.02;                       // far from the contact
  const std::size_t before = body.rebuilds.size(), ticks = world.tools[0].samples.size();
  touch_body(Exec(1), body, world.tools, 0.1, 0.11);
  ASSERT_EQ(body.rebuilds.size(), before + 1);
  EXPECT_NEAR(body.rebuilds.back().time, 0.101 + 1e-3 * kPatchTicks, 1e-9);
  const auto& samples = world.tools[0].samples;
  ASSERT_EQ(samples.size(), ticks + 10);
  for (std::size_t i = ticks; i < samples.size(); i++) {
    EXPECT_EQ(samples[i].new_patch, i == ticks + std::size_t(kPatchTicks));
    EXPECT_GT(norm(samples[i].force), 0.05) << "no tick is skipped";
  }
}

// A patch larger than the memory limit is refused before it is built, with advice.
TEST(FollowTools, RejectsPatchBeyondMemory) {
  const auto folder = test::fresh_folder();
  const Result<World> world =
      load_world(Exec(1), body_scene(folder, "patch = { radius = 0.06, refinement = 4 }\nmemory = 0.3\n",
                                     {"body.pad.block.count=[12, 12, 6]"}));
  ASSERT_FALSE(world);
  for (const char* words :
       {"body.pad.patch: a patch of ", "nodes of its own and would take ", "allowed are 0.3 GB",
        "a smaller patch.radius, a lower patch.refinement or more memory"})
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
}

// If a patch cannot follow, the previous one remains in use and a warning is given.
TEST(FollowTools, RejectedPatchKeepsPrevious) {
  World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  SfemBody& body = world.sfem_bodies[0];
  touch_body(Exec(1), body, world.tools, 0, 0.1);
  const std::vector<int> elements = body.touch.patch->elements;
  body.patch_memory = 1000;
  body.centers[0].x += 0.02;  // far from the contact
  touch_body(Exec(1), body, world.tools, 0.1, 0.11);
  EXPECT_EQ(body.touch.patch->elements, elements);
  EXPECT_EQ(body.rejected_patches, 1) << "tried once, not in every tick";
  EXPECT_GT(norm(world.tools[0].samples.back().force), 0.05) << "the force continues";
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find(
                "pad: the patch did not follow the tools 1 times, the previous one stayed: a patch of "),
            std::string::npos)
      << warnings[0];
}

// The estimated memory of a patch is between the actual one and four times of it.
TEST(FollowTools, PatchCostIsEstimated) {
  const World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  const SfemBody& body = world.sfem_bodies[0];
  const sfem::PatchCost cost =
      sfem::patch_cost(body.model, body.touch.patch->elements, body.refinement, body.centers);
  EXPECT_EQ(cost.local_nodes, std::size_t(body.touch.patch->local_nodes));
  EXPECT_EQ(cost.points, body.touch.patch->points.size());
  double stored_bytes = double(body.touch.patch->compliance.size()) * 8;
  for (const sfem::PatchLevel& level : body.touch.patch->levels)
    stored_bytes += double(level.motion.size() + level.compliance.size()) * 8;
  const auto& system = std::get<0>(body.touch.patch->system);
  stored_bytes +=
      4 * double(system.factor.size() + system.coupling.size() + system.green.size() + system.change.size());
  EXPECT_GT(cost.bytes, stored_bytes);
  EXPECT_LT(cost.bytes, 4 * stored_bytes);
}

}  // namespace
}  // namespace turgor
