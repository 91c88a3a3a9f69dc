// The patch that a scene leaves open: memory, expected error, forces against a finer mesh, and the direction
// of a frictionless force.
#include "turgor/sim/bodies/sfem/choose_patch.hpp"

#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/models/sfem/expected_error.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/report/force_error.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

constexpr Vec3d kSize{0.08, 0.08, 0.04};

/// Irregular tetrahedra of a block; their sides stay flat.
SolidMesh irregular_block(Vec3d size, Int3 count, unsigned seed) {
  SolidMesh mesh = hex_block(size, count);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  for (Vec3d& x : mesh.vertices)
    for (int axis = 0; axis < 3; axis++) {
      const double moved = shift(random) * size[axis] / count[axis];
      if (x[axis] > 1e-9 && x[axis] < size[axis] - 1e-9) x[axis] += moved;
    }
  return tetrahedralize(mesh);
}

/// A ball presses the block of this mesh frictionlessly, holds, and slides.
struct Press {
  double radius = 0.006, depth = 0.003;  // [m]
  double poisson = 0.45;
  Vec3d at{0.0331, 0.0457, 0.04};     // [m]
  Vec3d to{0.0421, 0.0417, 0.04};     // [m]
  double slide = 0;                   // duration [s]; 0: the ball stays over `at`
  std::string body = "memory = 0.6";  // keys; columns on demand save time
};

World pressed_world(const SolidMesh& mesh, const Press& press) {
  const auto folder = test::fresh_folder();
  EXPECT_TRUE(write_msh(folder / "block.msh", mesh));
  const std::string slide = press.slide > 0 ? fmt::format(", to = [{}, {}, {}], slide = {}", press.to.x,
                                                          press.to.y, press.to.z, press.slide)
                                            : "";
  const std::string text = fmt::format(
      "[world]\nduration = {}\n[body.pad]\nmodel = \"sfem\"\nmesh = \"block.msh\"\nyoung = 3e3\npoisson = "
      "{}\n"
      "fixed = {{ sides = \"bottom\", depth = 0 }}\ncache = false\n{}\n[tool.finger]\nbody = \"pad\"\n"
      "shape = {{ sphere = {} }}\nfriction = 0\npress = {{ at = [{}, {}, {}], depth = {}, "
      "start = 0, duration = 0.05, hold = 0.05{} }}\n",
      0.1 + press.slide, press.poisson, press.body, press.radius, press.at.x, press.at.y, press.at.z,
      press.depth, slide);
  const Result<Scene> scene = parse_scene(text, folder / "s.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// Force of the ball at the end of the press [N].
double press_force(World& world) {
  touch_body(Exec(2), world.sfem_bodies[0], world.tools, 0, 0.06);
  return world.tools[0].samples.back().force.z;
}

std::string notes_of(const SfemBody& body) {
  std::string all;
  for (const std::string& note : body.facts.notes) all += note + "\n";
  return all;
}

// A mesh whose usual patch does not fit into memory gets a smaller one, and a note states its cost.
TEST(ChoosePatch, FineMeshGetsPatchThatFits) {
  const SolidMesh mesh = irregular_block({0.06, 0.06, 0.03}, {12, 12, 6}, 4);
  for (const char* keys : {"memory = 0.3", "memory = 0.3\npatch = false"}) {
    World world = pressed_world(mesh, {.at = {0.031, 0.028, 0.03}, .body = keys});
    SfemBody& body = world.sfem_bodies[0];
    ASSERT_TRUE(body.facts.on_demand) << keys;
    EXPECT_LE(needs_of_patch(body, body.centers).bytes, 0.3e9) << keys;
    const double force = press_force(world);
    EXPECT_TRUE(force > 0.04 && force < 0.09) << keys << ": " << force;
    EXPECT_EQ(body.rejected_patches, 0) << body.rejection_reason;
    if (body.refinement > 1) {
      EXPECT_NE(notes_of(body).find("the patch was chosen: radius "), std::string::npos) << notes_of(body);
      EXPECT_LT(body.follow.radius, 0.02);
    }
  }
}

// Without a patch, notes and warnings do not speak of one that the scene could not know: a ball of 0.3 m on a
// body of 3 m reaches beyond the elements on which contact is computed.
TEST(ChoosePatch, BodyWithoutPatchIsNotToldOfOne) {
  const Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.2\n[body.big]\nmodel = \"sfem\"\nblock = { size = [3, 3, 1.5], count = [8, 8, "
      "4] }\n"
      "fixed = \"bottom\"\nyoung = 5e3\ncache = false\npatch = false\n[tool.ball]\nbody = \"big\"\n"
      "shape = { sphere = 0.3 }\npress = { at_fraction = [0.5, 0.5, 1], depth = 0.1, start = 0, duration = "
      "0.1 }\n",
      "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(Exec(2), *scene);
  ASSERT_TRUE(world) << world.error().message;
  touch_body(Exec(2), world->sfem_bodies[0], world->tools, 0, 0.1);
  EXPECT_EQ(notes_of(world->sfem_bodies[0]).find("patch"), std::string::npos);
  const std::vector<std::string> warnings = touch_warnings(*world);
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("ball: contact is computed within 20 mm of the tool"), std::string::npos)
      << warnings[0];
}

// Columns of earlier patches are forgotten, so that a long slide stays within the memory limit.
TEST(ChoosePatch, SlideStaysWithinMemory) {
  const SolidMesh mesh = irregular_block({0.09, 0.03, 0.03}, {18, 6, 6}, 4);
  World world = pressed_world(
      mesh, {.at = {0.015, 0.017, 0.03}, .to = {0.075, 0.013, 0.03}, .slide = 0.2, .body = "memory = 0.25"});
  SfemBody& body = world.sfem_bodies[0];
  ASSERT_TRUE(body.facts.on_demand);
  std::size_t most = 0;
  double least = 1;
  for (int frame = 0; frame < 30; frame++) {
    touch_body(Exec(2), body, world.tools, 0.01 * frame, 0.01 * (frame + 1));
    most = std::max(most, sfem::column_bytes(body.model.green));
    if (frame > 6) least = std::min(least, world.tools[0].samples.back().force.z);
  }
  EXPECT_GT(body.rebuilds.size(), 3u);
  EXPECT_EQ(body.rejected_patches, 0) << body.rejection_reason;
  EXPECT_GT(least, 0.04) << "N";
  EXPECT_LT(double(most), 0.25e9);
}

// The default patch keeps the force within 5 % of a finer mesh, and states an error below 5 % beforehand.
TEST(ChoosePatch, DefaultForceWithinFivePercent) {
  struct Case {
    Press press;
    double expected;  // [N], by refinement 3 on elements of 7.4 mm, all points as sites
  };
  const Case cases[] = {{{.radius = 0.006, .depth = 0.003}, 0.06032},
                        {{.radius = 0.006, .depth = 0.003, .poisson = 0.49}, 0.06130},
                        {{.radius = 0.012, .depth = 0.004}, 0.14704},
                        {{.radius = 0.012, .depth = 0.004, .poisson = 0.49}, 0.14998},
                        {{.radius = 0.010, .depth = 0.003, .at = {0.04, 0.04, 0.04}}, 0.08662}};
  const SolidMesh mesh = irregular_block(kSize, {12, 12, 6}, 3);
  for (const Case& c : cases) {
    World world = pressed_world(mesh, c.press);
    const double force = press_force(world);
    std::printf("radius %.3g mm, nu %.2f: %.2f mN, expected %.2f mN; patch of %.3g mm, refinement %d\n",
                1e3 * c.press.radius, c.press.poisson, 1e3 * force, 1e3 * c.expected,
                1e3 * world.sfem_bodies[0].follow.radius, world.sfem_bodies[0].refinement);
    EXPECT_NEAR(force, c.expected, 0.05 * c.expected) << c.press.radius << " m, " << c.press.poisson;
    const auto touched = touched_elements(world, world.tools[0]);
    ASSERT_TRUE(touched);
    EXPECT_LT(sfem::expected_error(*touched), 0.05);
  }
}

// A frictionless ball that slides on a flat side is pushed back along its normal.
TEST(ChoosePatch, FrictionlessForceIsNormal) {
  const SolidMesh mesh = irregular_block(kSize, {12, 12, 6}, 8);
  for (const double radius : {0.006, 0.010}) {
    World world = pressed_world(mesh, {.radius = radius, .slide = 0.2});
    touch_body(Exec(2), world.sfem_bodies[0], world.tools, 0, 0.3);
    double most = 0;
    for (const ForceSample& s : world.tools[0].samples)
      if (s.time > 0.06 && s.time < 0.3) most = std::max(most, std::hypot(s.force.x, s.force.y) / s.force.z);
    std::printf("radius %.3g mm: tangential force up to %.2f %% of the normal one\n", 1e3 * radius,
                100 * most);
    EXPECT_LT(most, 0.02) << radius;
  }
}

// Keys of the scene are kept.
TEST(ChoosePatch, KeysOfSceneAreKept) {
  const World world = pressed_world(irregular_block(kSize, {4, 4, 2}, 3),
                                    {.body = "patch = { radius = 0.03, refinement = 3 }"});
  EXPECT_EQ(world.sfem_bodies[0].follow.radius, 0.03);
  EXPECT_EQ(world.sfem_bodies[0].refinement, 3);
  EXPECT_EQ(notes_of(world.sfem_bodies[0]).find("chosen"), std::string::npos);
}

}  // namespace
}  // namespace turgor
