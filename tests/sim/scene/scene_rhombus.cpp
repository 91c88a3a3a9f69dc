#include "turgor/sim/scene/scene_rhombus.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/scene/scene_error.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using test::error_of;

constexpr const char* kLiver = R"([body.liver]
model = "rhombus"
surface = { phantom = "liver" }
)";

// The keys reach the model.
TEST(SceneRhombus, KeysReachModel) {
  const Scene scene = *parse_scene(std::string(kLiver) + R"(tissue = "breast-fat"
bulge = 0.4
chain = { angle = 30, side = 0.004 }
viscosity = { ratio = 0.5, time = 0.2 }
stiffness = { labels = "seg.nii.gz", factors = { nodule = 8, 5 = 2 }, depth = 0.01 }
[tool.jaws]
body = "liver"
shape = { forceps = "phantom", opening = 0.01, closing = 0.2 }
grasp = { at_fraction = [0.5, 0.5, 1], pull = 0.012 }
)",
                                   "s.toml");
  ASSERT_EQ(scene.rhombus_bodies.size(), 1u);
  const RhombusScene& liver = scene.rhombus_bodies[0];
  EXPECT_NEAR(liver.params.chain.normal, 12.958632 * 3.25, 1e-9) << "from the tissue";
  EXPECT_NEAR(liver.params.chain.angle, 0.5235988, 1e-6) << "from the key";
  EXPECT_EQ(liver.params.chain.side, 0.004);
  EXPECT_EQ(liver.params.bulge, 0.4);
  EXPECT_EQ(liver.params.viscosity, one_pair(0.5, 0.2));
  const auto& stiffness = std::get<LabelStiffness>(liver.stiffness->source);
  EXPECT_EQ(stiffness.factors.at(5), 2);
  EXPECT_EQ(stiffness.factors.size(), 2u);
  EXPECT_EQ(std::get<ForcepsTool>(scene.tools[0].shape).opening, 0.01);
  EXPECT_EQ(std::get<Grasp>(scene.tools[0].motion).pull, 0.012);
}

// Errors name the key and its location in the file.
TEST(SceneRhombus, ErrorsNameLocation) {
  EXPECT_NE(error_of("[body.b]\nmodel = \"rhombus\"\n").find("surface or surface_of is missing"),
            std::string::npos);
  EXPECT_NE(error_of("[body.b]\nmodel = \"rhombus\"\nsurface_of = \"x\"\n")
                .find("the scene has no body x with model = \"sfem\""),
            std::string::npos);
  EXPECT_NE(error_of(std::string(kLiver) + "tissue = \"livr\"\n").find("found \"livr\""), std::string::npos);
  EXPECT_NE(error_of(std::string(kLiver) + "chain = { angle = 90 }\n").find("s.toml:4:"), std::string::npos);
  EXPECT_NE(error_of(std::string(kLiver) + "chain = { normal = -1 }\n").find("found -1"), std::string::npos);
  for (const char* key : {"normal", "tangential"})
    EXPECT_NE(error_of(std::string(kLiver) + "chain = { " + key + " = 1e300 }\n")
                  .find("expected a number from 1e-06 to 1000000 [N/m], found 1e+300"),
              std::string::npos)
        << key;
  EXPECT_NE(error_of(std::string(kLiver) + "bulgy = 1\n").find("did you mean bulge?"), std::string::npos);
  EXPECT_NE(error_of(std::string(kLiver) + "stiffness = { labels = \"s.nii\", factors = { nodul = 2 } }\n")
                .find("did you mean nodule?"),
            std::string::npos);
  for (const char* factors :
       {"1", "[]", "[[40, 1], [40, 2]]", "[[40]]", "[[40, 0]]", "[40, 1]", "{ nodule = 8 }"})
    EXPECT_NE(error_of(std::string(kLiver) +
                       "stiffness = { ct = { phantom = \"torso\" }, factors = " + factors + " }\n")
                  .find("expected pairs [HU, factor from 1e-6 to 1e6]"),
              std::string::npos)
        << factors;
  EXPECT_NE(
      error_of(std::string(kLiver) + "stiffness = { ct = \"a\", labels = \"b\", factors = { 5 = 2 } }\n")
          .find("from labels or from a CT"),
      std::string::npos);
}

/// Largest force on the tool [N].
double largest_force(const World& world) {
  double largest = 0;
  for (const ForceSample& s : world.tools[0].samples) largest = std::max(largest, norm(s.force));
  return largest;
}

World loaded(const std::string& text) { return *load_world(Exec(1), *parse_scene(text, "s.toml")); }

// A press has the force of the chain model in newtons, and the surface recovers completely.
TEST(SceneRhombus, PressMatchesTipForceAndRecovers) {
  World world = loaded(std::string(kLiver) + R"([world]
duration = 1.3
[tool.ball]
body = "liver"
shape = { sphere = 0.005 }
press = { at_fraction = [0.3, 0.5, 1], depth = 0.008 }
)");
  const Exec exec(1);
  for (int frame = 0; frame < 80; frame++) ASSERT_TRUE(step(exec, world)) << frame;
  const RhombusBody& liver = world.rhombus_bodies[0];
  const rhombus::Tip tip = rhombus::tip_on(liver.model.chain, 0.005);
  EXPECT_NEAR(largest_force(world) / rhombus::force_of_tip(liver.model.chain, tip, 0.008), 1, 1e-3);
  double deepest = 0;
  for (const ForceSample& s : world.tools[0].samples) deepest = std::max(deepest, s.depth);
  EXPECT_NEAR(deepest, 0.008, 2e-4);
  EXPECT_EQ(world.tools[0].samples.back().contacts, 0);
  BodySnapshot now;
  show(exec, liver, now);
  for (const Vec3 u : now.displacement) ASSERT_EQ(u, Vec3{});
  EXPECT_LT(liver.jump, 1e-5 * 1.5 * 2 * 5400 / 0.75 * 0.005) << "N, in 10 um; a disc's stiffness";
}

// Forceps press, pull and release the tissue.
TEST(SceneRhombus, ForcepsPressPullAndRelease) {
  World world = loaded(std::string(kLiver) + R"([world]
duration = 3
[tool.forceps]
body = "liver"
shape = { forceps = "phantom" }
grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.006, pull = 0.012 }
)");
  const Exec exec(1);
  double pressed = 0, pulled = 0;
  for (int frame = 0; frame < 180; frame++) ASSERT_TRUE(step(exec, world));
  for (const ForceSample& s : world.tools[0].samples) {
    const Vec3d normal = axes_of(world.tools[0].path.rows[0].orientation).column[2];
    pressed = std::max(pressed, dot(s.force, normal)), pulled = std::max(pulled, -dot(s.force, normal));
  }
  std::printf("forceps: pressed %.4f N, pulled %.4f N, largest jump per 10 um %.2e N\n", pressed, pulled,
              world.rhombus_bodies[0].jump);
  EXPECT_GT(pressed, 1e-3);
  EXPECT_GT(pulled, 1e-2);
  EXPECT_EQ(world.tools[0].samples.back().force, Vec3d{});
  EXPECT_EQ(
      rhombus::step(exec, world.rhombus_bodies[0].model, world.rhombus_bodies[0].state).largest_displacement,
      0);
}

/// A CT around the phantom liver: soft for x < 0, dense for x > 0.
CtVolume two_halves() {
  CtVolume ct;
  ct.grid = Grid{.size = {40, 30, 24}, .spacing = {0.01, 0.01, 0.01}, .origin = {-0.195, -0.15, -0.12}};
  ct.samples.resize(std::size_t(sample_count(ct.grid)));
  for (int k = 0; k < 24; k++)
    for (int j = 0; j < 30; j++)
      for (int i = 0; i < 40; i++) ct.at(i, j, k) = i < 20 ? 40 : 300;
  return ct;
}

// The stiffness follows the gray values of a CT.
TEST(SceneRhombus, StiffnessFollowsGrayValues) {
  const std::filesystem::path file = test::fresh_folder() / "ct.nrrd";
  ASSERT_TRUE(write_ct(file, two_halves()));
  const World world = loaded(std::string(kLiver) + "stiffness = { ct = \"" + file.string() +
                             "\", factors = [[0, 0.5], [80, 1.5], [200, 8]], depth = 0.01 }\n");
  const rhombus::Model& model = world.rhombus_bodies[0].model;
  int soft = 0, dense = 0;
  for (std::size_t v = 0; v < model.surface.vertices.size(); v++) {
    const double x = model.surface.vertices[v].x;
    if (std::abs(x) < 0.05) continue;  // smoothed between the halves
    (x < 0 ? soft : dense)++;
    ASSERT_NEAR(model.stiffness[v], x < 0 ? 1 : 8, 1e-9) << "halfway between 0 and 80 HU, or beyond 200 HU";
  }
  EXPECT_GT(soft, 100);
  EXPECT_GT(dense, 100);
}

// A rhombus body can use the surface of an SFEM body.
TEST(SceneRhombus, UsesSurfaceOfSfemBody) {
  const World world = loaded(R"([body.block]
model = "sfem"
block = { size = [0.1, 0.1, 0.05], count = [6, 6, 3] }
cache = false
[body.skin]
model = "rhombus"
surface_of = "block"
)");
  EXPECT_EQ(world.rhombus_bodies[0].model.surface.triangles.size(),
            world.sfem_bodies[0].model.surface.triangles.size());
  EXPECT_NEAR(world.rhombus_bodies[0].volume, 0.1 * 0.1 * 0.05, 1e-12);
}

// A real liver is pressed and pulled with forceps without force jumps.
TEST(SceneRhombus, RealLiverIsPressedAndPulled) {
  const std::filesystem::path file =
      std::filesystem::path(TURGOR_SOURCE_DIR) / "../shared/data/mesh/liver-smooth.obj";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no ../shared/data/mesh/liver-smooth.obj";
  World world = loaded("[body.liver]\nmodel = \"rhombus\"\nsurface = \"" + file.string() +
                       "\"\nscale = 0.02\nbulge = 0.5\n[tool.forceps]\nbody = \"liver\"\nshape = { forceps "
                       "= \"phantom\" }\ngrasp = { at_fraction = [0.5, 0.5, 1], depth = 0.005 }\n");
  const Exec exec(1);
  for (int frame = 0; frame < 180; frame++) ASSERT_TRUE(step(exec, world));
  EXPECT_EQ(world.rhombus_bodies[0].model.surface.vertices.size(), 2194u);
  EXPECT_GT(largest_force(world), 0.01);
  EXPECT_LT(world.rhombus_bodies[0].jump, 0.05 * largest_force(world));
  EXPECT_EQ(world.tools[0].samples.back().force, Vec3d{});
}

}  // namespace
}  // namespace turgor
