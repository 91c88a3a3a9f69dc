// Scenes with a nonlinear law or a texture.
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

using test::body_scene;
using test::sfem_world;

constexpr const char* kPatch = "patch = { radius = 0.013, refinement = 2 }\n";

World law_world(const std::string& body, int threads, double depth = 0.004, double duration = 0.15) {
  const Exec exec(threads);
  const Scene scene = body_scene(
      test::fresh_folder(), kPatch + body,
      {"tool.finger.press.depth=" + std::to_string(depth), "world.duration=" + std::to_string(duration)});
  World world = sfem_world(exec, scene);
  for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(exec, world));
  return world;
}

double force_at(const World& world, double time) {
  for (const ForceSample& s : world.tools[0].samples)
    if (s.time >= time) return norm(s.force);
  return 0;
}

// A law stiffens a deep press and hardly changes a shallow one. The bits do not depend on threads.
TEST(LawSfem, DeepPressIsStifferThanLinear) {
  const std::string law = "law = \"exponential\"\nstiffening = 4\n";
  const World linear = law_world("", 1), stiff = law_world(law, 1), again = law_world(law, 4);
  EXPECT_GT(force_at(stiff, 0.14), 1.1 * force_at(linear, 0.14));
  EXPECT_NEAR(force_at(law_world(law, 1, 2e-4), 0.14), force_at(law_world("", 1, 2e-4), 0.14),
              0.02 * force_at(linear, 0.14));
  EXPECT_EQ(state_hash(stiff), state_hash(again));
  const LawSummary& sum = stiff.sfem_bodies[0].law_summary;
  EXPECT_GT(sum.solutions, 10);
  EXPECT_LE(5 * sum.unconverged, sum.solutions);
  EXPECT_GT(sum.strain, 0.1);
  // coarse forces have the sum of the contact forces
  Vec3d far, near;
  for (const contact::VertexForce& f : coarse_forces_now(stiff.sfem_bodies[0])) far += f.force;
  for (const Vec3d f : stiff.sfem_bodies[0].now.force) near += f;
  EXPECT_GT(norm(near), 0.01);
  EXPECT_NEAR(norm(far - near), 0, 0.02 * norm(near));
}

// A linear body says that it is strained beyond its law; a nonlinear one does not.
TEST(LawSfem, StrainBeyondLinearLaw_Warns) {
  const World deep = law_world("", 1, 0.006), shallow = law_world("", 1, 5e-4);
  ASSERT_EQ(overstrained(deep).size(), 1u);
  EXPECT_NE(overstrained(deep)[0].find("pad: its surface was strained by"), std::string::npos);
  EXPECT_TRUE(overstrained(shallow).empty());
}

// Keys that exclude each other, and values that are no law, are refused.
TEST(LawSfem, WrongKeysAreRefused) {
  const auto error = [](const std::string& body) {
    const Result<Scene> scene = parse_scene(test::sfem_scene_text(body), "pad.toml", {});
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_NE(error("law = \"rubber\"\n").find("exponential"), std::string::npos);
  EXPECT_NE(error("stiffening = 3\n").find("law"), std::string::npos);
  EXPECT_NE(error("law = \"neo_hookean\"\nrotations = true\n").find("not computed together"),
            std::string::npos);
  EXPECT_NE(error("law = \"neo_hookean\"\nviscosity = { pairs = [[0.2, 0.1]] }\n").find("viscosity"),
            std::string::npos);
  EXPECT_NE(error("texture = { roughness = -1 }\n").find("roughness"), std::string::npos);
}

// While the tool slides, the force on a textured body differs by a vibration of speed / wavelength; before,
// it does not.
TEST(LawSfem, TextureVibratesWhileSliding) {
  const World smooth = law_world("", 1, 0.002, 0.3),
              rough = law_world("texture = { roughness = 5e-6, wavelength = 2e-3 }\n", 1, 0.002, 0.3);
  const auto& a = smooth.tools[0].samples;
  const auto& b = rough.tools[0].samples;
  ASSERT_EQ(a.size(), b.size());
  double pressed = 0, slid = 0;
  int crossings = 0;
  double before = 0, first = 0, last = 0;
  for (std::size_t i = 0; i < a.size(); i++) {
    const double d = b[i].force.x - a[i].force.x;
    if (a[i].time < 0.14) pressed = std::max(pressed, norm(b[i].force - a[i].force));
    if (a[i].time < 0.19 || a[i].time > 0.26) continue;
    slid = std::max(slid, std::abs(d));
    if (before < 0 && d >= 0) {
      if (crossings++ == 0) first = a[i].position.x;
      last = a[i].position.x;
    }
    before = d;
  }
  EXPECT_LT(pressed, 0.2 * slid);
  ASSERT_GT(crossings, 2);
  EXPECT_NEAR(std::abs(last - first) / (crossings - 1), 2e-3, 2.5e-4);
  EXPECT_GT(slid, 0);
}

// A map of heights is read relative to the scene, and vibrates while the tool slides.
TEST(LawSfem, HeightMapVibratesWhileSliding) {
  const std::filesystem::path folder = test::fresh_folder();
  std::ofstream(folder / "skin.csv") << "0, 2, 5, 1\n4, 0, 3, 2\n1, 5, 0, 4\n";
  const auto run = [&](const std::string& body) {
    const Scene scene =
        body_scene(folder, kPatch + body, {"tool.finger.press.depth=0.002", "world.duration=0.3"});
    World world = sfem_world(Exec(1), scene);
    for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(Exec(1), world));
    return world;
  };
  const World smooth = run(""),
              rough = run("texture = { height_map = \"skin.csv\", spacing = 8e-4, scale = 6e-6 }\n");
  ASSERT_TRUE(rough.sfem_bodies[0].texture.map);
  EXPECT_EQ(rough.sfem_bodies[0].texture.map->columns, 4);
  EXPECT_NEAR(rough.sfem_bodies[0].texture.map->range, 3e-5, 1e-12);
  const auto& a = smooth.tools[0].samples;
  const auto& b = rough.tools[0].samples;
  double pressed = 0, slid = 0;
  for (std::size_t i = 0; i < a.size(); i++)
    (a[i].time < 0.14 ? pressed : slid) =
        std::max(a[i].time < 0.14 ? pressed : slid, norm(b[i].force - a[i].force));
  EXPECT_GT(slid, 1e-3);
  EXPECT_LT(pressed, 0.2 * slid);
}

// A body that ends while its worker solves keeps the patch until the worker has finished.
TEST(LawSfem, WorkerEndsBeforeItsPatch) {
  bool had_patch = false;
  {
    World world = law_world("law = \"exponential\"\nstiffening = 4\n", 1, 0.002, 0.05);
    SfemBody& body = world.sfem_bodies[0];
    ASSERT_TRUE(bool(body.nonlinear));
    if (body.worker && body.worker->is_busy()) (void)body.worker->finish();
    body.worker = std::make_unique<PatchWorker>();
    body.worker->begin([&body, &had_patch]() -> BuiltPatch {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      had_patch = bool(body.nonlinear) && !body.nonlinear->u.empty();
      return {Error{"none"}, 0};
    });
  }
  EXPECT_TRUE(had_patch);
}

// Files that are no map, and keys that exclude each other, are refused with file, line or key.
TEST(LawSfem, WrongHeightMapsAreRefused) {
  const std::filesystem::path folder = test::fresh_folder();
  const auto error = [&](const std::string& text, const std::string& keys = "") {
    std::ofstream(folder / "skin.csv") << text;
    const Scene scene =
        body_scene(folder, kPatch + std::string("texture = { height_map = \"skin.csv\"") + keys + " }\n");
    const Result<World> world = load_world(Exec(1), scene);
    return world ? std::string() : world.error().message;
  };
  EXPECT_NE(error("1e-6, 2e-6\n3e-6\n").find("skin.csv:2: expected 2 heights"), std::string::npos);
  EXPECT_NE(error("1, 2\n3, 4\n").find("within 1 mm of their mean"), std::string::npos);
  EXPECT_NE(error("5e-6\n").find("at least two heights"), std::string::npos);
  EXPECT_EQ(error("1, 2\n3, 4\n", ", scale = 1e-6"), "");
  const auto refused = [](const std::string& body) {
    const Result<Scene> scene = parse_scene(test::sfem_scene_text(body), "pad.toml", {});
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_NE(refused("texture = { height_map = \"a.csv\", roughness = 1e-6 }\n").find("not both"),
            std::string::npos);
  EXPECT_NE(refused("texture = { spacing = 1e-4 }\n").find("belongs to a height_map"), std::string::npos);
}

// Linear elements beyond 0.49 lock and are refused; averaged ones are not.
TEST(LawSfem, LockingElementsAreRefused) {
  const auto error = [](const std::string& body) {
    const Result<Scene> scene =
        parse_scene(test::sfem_scene_text(body), "pad.toml", {"body.pad.poisson=0.499"});
    return scene ? std::string() : scene.error().message;
  };
  EXPECT_NE(error("").find("which lock beyond"), std::string::npos);
  EXPECT_EQ(error("formulation = \"averaged\"\n"), "");
}

}  // namespace
}  // namespace turgor
