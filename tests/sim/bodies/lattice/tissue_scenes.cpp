// Scenes of layered tissue: the limb of scenes/arm.toml under a probe, and the undermined wound of
// scenes/undermine.toml, both with coarse cells.
#include <algorithm>
#include <cstdio>

#include <gtest/gtest.h>

#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

struct SceneRun {
  World world;
  Json report;
};
SceneRun run_scene_file(const std::string& name, const std::vector<std::string>& overrides) {
  const Exec exec(2);
  const std::filesystem::path file = std::filesystem::path(TURGOR_SOURCE_DIR "/scenes") / name;
  const Result<Scene> scene = read_scene(file, overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  const Result<Simulated> done = simulate(exec, *scene, *world, {});
  EXPECT_TRUE(done);
  Json report = simulation_report(exec, *scene, *world, done->measures, {});
  return {std::move(*world), std::move(report)};
}

/// Force of the probe at its deepest [N].
double probe_force(std::vector<std::string> overrides) {
  for (const char* one :
       {"body.arm.spacing=0.014", "world.duration=0.5", "world.frame_rate=50", "tool.probe.press.start=0",
        "tool.probe.press.duration=0.3", "tool.probe.press.hold=0.2"})
    overrides.emplace_back(one);
  const SceneRun run = run_scene_file("arm.toml", overrides);
  double most = 0;
  for (const ForceSample& s : run.world.tools[0].samples) most = std::max(most, norm(s.force));
  return most;
}

// The limb of three layers resists a probe more than a limb of its softest law and less than one of its
// stiffest.
TEST(TissueScenes, ArmLiesBetweenItsLayers) {
  const auto all = [](const std::string& young, const std::string& stiffening) {
    std::vector<std::string> overrides;
    for (const char* layer : {"0", "1", "2"}) {
      const std::string key = std::string("body.arm.layers[") + layer + "].";
      overrides.push_back(key + "young=" + young), overrides.push_back(key + "stiffening=" + stiffening);
    }
    return overrides;
  };
  const double layered = probe_force({}), soft = probe_force(all("1e4", "1")),
               stiff = probe_force(all("6e4", "4"));
  EXPECT_GT(soft, 0.5);
  EXPECT_GT(layered, 1.02 * soft);
  EXPECT_LT(layered, 0.6 * stiff);
  std::printf("layers %.2f N, soft %.2f N, stiff %.2f N\n", layered, soft, stiff);
}

// Skin that is freed from the tissue below it on both sides of a cut gapes further.
TEST(TissueScenes, UnderminedCutGapesFurther) {
  const auto gape = [](const std::string& width) {
    const SceneRun run = run_scene_file(
        "undermine.toml",
        {"body.torso.ct={ phantom = \"torso\", size = [96, 96, 56], spacing_mm = [4.16, 4.16, 5.36] }",
         "body.torso.spacing=0.0084", "world.duration=0.8", "world.frame_rate=50",
         "incision.midline.depth=0.017", "incision.midline.undermine.depth=0.012",
         "incision.midline.undermine.width=" + width});
    return run.report["wounds"][0]["gape_max_mm"].get<double>();
  };
  const double with = gape("0.03"), without = gape("0");
  EXPECT_GT(without, 2);
  EXPECT_GT(with, 1.05 * without);
  std::printf("gape %.2f mm, without undermining %.2f mm\n", with, without);
}

}  // namespace
}  // namespace turgor
