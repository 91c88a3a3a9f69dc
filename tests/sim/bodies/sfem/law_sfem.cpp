// Scenes with a nonlinear law or a texture.
#include <cmath>

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

}  // namespace
}  // namespace turgor
