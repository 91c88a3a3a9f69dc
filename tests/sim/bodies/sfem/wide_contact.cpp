// A wide tool pressed deep: more points touch than a tick solves one by one. The force of clusters is
// compared with the force of all points on the same patch.
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/force_error.hpp"
#include "turgor/sim/report/report_touch.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

constexpr int kAllPoints = 500;

const std::string kBlock =
    "block = { size = [0.05, 0.05, 0.025], count = [12, 12, 6] }\nfixed = \"bottom\"\nyoung = 5e3\npoisson = "
    "0.45\n";
/// Soft above stiff.
const std::string kLayers =
    kBlock + "inclusion = { deep = { center = [0.025, 0.025, -0.08], radius = 0.095, young = 2e4 } }\n";

World pressed_world(const std::string& body, int refinement, double depth, int contacts) {
  const std::string text = "[world]\nduration = 0.5\n[body.pad]\nmodel = \"sfem\"\ncache = false\n" + body +
                           "contacts = " + std::to_string(contacts) +
                           "\npatch = { radius = 0.01, refinement = " + std::to_string(refinement) +
                           " }\n[tool.ball]\nbody = \"pad\"\nshape = { sphere = 0.008 }\n"
                           "press = { at_fraction = [0.5, 0.5, 1], depth = " +
                           fmt::format("{:g}", depth) + ", start = 0, duration = 0.05, hold = 0.05 }\n";
  const Result<Scene> scene = parse_scene(text, fs::path("s.toml"));
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  touch_body(Exec(1), world->sfem_bodies[0], world->tools, 0, 0.06);
  return std::move(*world);
}

double force_of(const World& world) { return norm(world.sfem_bodies[0].now.forces[0].force); }

/// The default and all points, at every refinement: forces within 3 % of each other. With each refinement a
/// coarse body softens by some percent, while smaller facets add contacts. Neither halves the force.
void expect_no_force_lost(const std::string& body, double depth, int finest) {
  double before = 0;
  for (int r = 1; r <= finest; r++) {
    const World all = pressed_world(body, r, depth, kAllPoints), few = pressed_world(body, r, depth, 32);
    const contact::ToolForce &a = all.sfem_bodies[0].now.forces[0], &f = few.sfem_bodies[0].now.forces[0];
    std::vector<double> ticks;
    for (const ForceSample& s : few.tools[0].samples) ticks.push_back(s.tick_seconds);
    std::printf(
        "%.0f mm, r = %d: %zu points, all %.5f N (%d contacts), clusters %.5f N (%d contacts, level %d), "
        "error %.2f %%, tick p50 %.3f p90 %.3f ms\n",
        depth * 1e3, r, few.sfem_bodies[0].touch.patch->points.size(), force_of(all), a.contacts,
        force_of(few), f.contacts, f.level, 100 * (force_of(few) / force_of(all) - 1),
        percentile(ticks, 0.5) * 1e3, percentile(ticks, 0.9) * 1e3);
    std::fflush(stdout);
    EXPECT_EQ(a.dropped, 0);
    EXPECT_EQ(a.level, 0) << "all points are within the capacity";
    EXPECT_EQ(f.dropped, 0);
    EXPECT_NEAR(force_of(few), force_of(all), 0.03 * force_of(all)) << depth << " m, r = " << r;
    EXPECT_GT(force_of(few), 0.93 * before) << "a finer patch loses no force; it may be slightly softer";
    before = force_of(few);
    for (const World* world : {&all, &few}) EXPECT_EQ(world->tools[0].limits.dropped_ticks, 0);
  }
}

// On a block, clusters of contact points keep the force of all points.
TEST(WideContact, BlockKeepsForce) {
  expect_no_force_lost(kBlock, 0.003, 4);
  expect_no_force_lost(kBlock, 0.006, 4);
}

// On layers, clusters of contact points keep the force of all points.
TEST(WideContact, LayersKeepForce) {
  expect_no_force_lost(kLayers, 0.003, 3);
  expect_no_force_lost(kLayers, 0.006, 3);
}

// On a real liver, clusters of contact points keep the force of all points.
TEST(WideContact, LiverKeepsForce) {
  const fs::path liver = fs::path(TURGOR_SOURCE_DIR) / "../shared/data/mesh/liver.msh";
  if (!fs::exists(liver))
    GTEST_SKIP() << liver.string() << " is absent: real data is not part of the project";
  const std::string body = "mesh = \"" + fs::absolute(liver).string() +
                           "\"\nscale = 0.005\nfixed = \"back\"\nelements = \"linear\"\n";
  expect_no_force_lost(body, 0.003, 4);
}

// The force is continuous when clusters replace single points.
TEST(WideContact, ClusteringKeepsForceContinuous) {
  const World world = pressed_world(kBlock, 3, 0.006, 16);
  const auto& samples = world.tools[0].samples;
  EXPECT_GE(world.tools[0].limits.coarsest, 1);
  double largest = 0, steepest = 0;
  for (std::size_t i = 1; i < samples.size(); i++) {
    steepest = std::max(steepest, norm(samples[i].force - samples[i - 1].force));
    largest = std::max(largest, norm(samples[i].force));
  }
  std::printf("largest %.4f N, largest change in a tick %.4f N\n", largest, steepest);
  EXPECT_LT(steepest, 0.08 * largest);
}

// Contacts beyond the capacity are counted, and a warning is given.
TEST(WideContact, DroppedContactsAreReported) {
  World world = pressed_world(kBlock, 2, 0.003, 8);
  SfemBody& body = world.sfem_bodies[0];
  sfem::Patch patch = *body.touch.patch;
  patch.levels.clear();  // as on a patch with too many clusters
  body.touch.patch = std::make_shared<const sfem::Patch>(std::move(patch));
  body.touch.state = contact::make_touch_state(*body.touch.patch, 1, {.capacity = 8});
  touch_body(Exec(1), body, world.tools, 0.06, 0.08);
  EXPECT_GT(world.tools[0].limits.dropped_ticks, 10);
  EXPECT_GT(world.tools[0].limits.dropped_most, 1);
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("its force is too small then; raise contacts of the body"), std::string::npos)
      << warnings[0];
}

// A warning about coarse elements suggests a sufficient refinement. A ball of 8 mm pressed 1 mm covers 2.8
// mm; cells are 4.2 mm.
TEST(WideContact, CoarseElementsSuggestRefinement) {
  const auto warning_at = [](int refinement, double depth) {
    const std::vector<std::string> sentences =
        force_error_warnings(pressed_world(kBlock, refinement, depth, 64));
    return sentences.empty() ? std::string() : sentences[0];
  };
  EXPECT_NE(warning_at(1, 1e-9).find("the expected force error is more than 100 %"), std::string::npos)
      << warning_at(1, 1e-9);
  const std::string coarse = warning_at(1, 0.001);
  EXPECT_NE(coarse.find("into 1 segments"), std::string::npos) << coarse;
  EXPECT_NE(coarse.find("a contact radius of 2.83 mm"), std::string::npos) << coarse;
  const std::size_t at = coarse.find("patch.refinement = ");
  ASSERT_NE(at, std::string::npos) << coarse;
  const int enough = coarse[at + 19] - '0';
  EXPECT_EQ(warning_at(enough, 0.001), "");
  EXPECT_NE(warning_at(enough - 1, 0.001), "");
}

}  // namespace
}  // namespace turgor
