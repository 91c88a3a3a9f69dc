// A sheet on rhombus chains: the weight on both bodies, and the dent.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/sim/bodies/cloth/cloth_support.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

/// Rhombus chains with the surface of the pad.
std::string on_chains() {
  return std::string(kPad) + "[body.chains]\nmodel = \"rhombus\"\nsurface_of = \"pad\"\n" + kSheetOnPad;
}

// Chains carry the sheet's weight and sink like an elastic half-space under a uniform square load
// (Boussinesq).
TEST(ClothOnChains, HeavySheetMatchesHalfSpace) {
  const std::string finer = "body.pad.block={ size = [0.06, 0.06, 0.03], count = [13, 11, 4] }";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {finer}, {"body.sheet.fabric.density=5"}}) {
    std::vector<std::string> overrides{"body.sheet.obstacle.pad.body=chains"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    World world = must_load(on_chains(), overrides);
    run(world, 180);
    const RhombusBody& chains = world.rhombus_bodies[0];
    const ClothBody& sheet = world.cloth_bodies[0];
    const double weight = sheet.model.total_mass * kGravity, pressure = weight / (0.06 * 0.06);
    EXPECT_NEAR(mean_of_last(sheet.obstacles[0].force, 60).z, -weight, 0.01 * weight) << "N, on the cloth";
    const Vec3d body_force = total_force(chains.cloth);
    EXPECT_NEAR(body_force.z, -weight, 0.01 * weight) << "N, on the chains";
    EXPECT_LT(std::hypot(body_force.x, body_force.y), 0.01 * weight);
    double most = 0;
    for (const Vec3d u : chains.state.displacement) most = std::max(most, -u.z);
    const double expected = 1.1222 * pressure * 0.06 / (5.4e3 / 0.75);
    EXPECT_NEAR(most, expected, 0.05 * expected) << "m: 4 ln(1 + sqrt 2) / pi p B / E*, Boussinesq";
  }
}

// A liver of chains carries a drape's weight in two orientations.
TEST(ClothOnChains, LiverCarriesDrape) {
  struct Setup {
    const char *gravity, *sheet, *tissue;
    int down;
  };
  for (const auto& [gravity, sheet, tissue, down] :
       {Setup{"[0, 9.81, 0]", "corner = [-0.05, -0.075, -0.04], side = [0, 0, 0.08], up = [0.1, 0, 0]",
              "liver", 1},
        Setup{"[0, 0, -9.81]", "corner = [-0.04, -0.04, 0.055], side = [0.08, 0, 0], up = [0, 0.08, 0]",
              "liver-porcine", 2}}) {
    World world = must_load(fmt::format(R"(
[world]
gravity = {}
[body.liver]
model = "rhombus"
surface = {{ phantom = "liver", detail = 0.6 }}
tissue = "{}"
[body.sheet]
model = "cloth"
sheet = {{ {}, columns = 15, rows = 17 }}
fabric = {{ law = "springs", density = 1, warp = 100, weft = 100 }}
solver = {{ method = "two_level" }}
collision = {{ self = false, thickness = 0.003 }}
wind = {{ density = 0 }}
damping = {{ motion = 3 }}
[body.sheet.obstacle.liver]
body = "liver"
friction = 1
)",
                                        gravity, tissue, sheet));
    run(world, 180);
    Vec3d body_force;
    for (int n = 0; n < 60; n++)
      run(world, 1), body_force += total_force(world.rhombus_bodies[0].cloth) / 60.0;
    const double weight = world.cloth_bodies[0].model.total_mass * kGravity, sign = down == 1 ? 1 : -1;
    const Vec3d cloth_force = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
    EXPECT_NEAR(sign * cloth_force[down], weight, 0.01 * weight);
    EXPECT_NEAR(norm(cloth_force), weight, 0.01 * weight);
    EXPECT_NEAR(norm(body_force - cloth_force), 0, 0.01 * weight);
  }
}

// Cloth follows the dent that a tool presses into rhombus chains.
TEST(ClothOnChains, ClothFollowsToolDent) {
  World world = must_load(R"(
[world]
gravity = [0, 0, -9.81]
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 1.5 }
)");
  const Box box = box_around(world.rhombus_bodies[0].model.surface.vertices);
  const std::string text = fmt::format(R"(
[world]
gravity = [0, 9.81, 0]
[body.liver]
model = "rhombus"
surface = {{ phantom = "liver", detail = 1.5 }}
[tool.finger]
body = "liver"
shape = {{ sphere = 0.006 }}
press = {{ at_fraction = [0.5, 0, 0.5], depth = 0.01, start = 1, duration = 0.3, hold = 2 }}
[body.sheet]
model = "cloth"
sheet = {{ corner = [{}, {}, {}], side = [0, 0, 0.1], up = [0.1, 0, 0], columns = 20, rows = 20 }}
fabric = {{ law = "springs" }}
solver = {{ method = "sweeps" }}
collision = {{ self = false, thickness = 0.002 }}
wind = {{ density = 0 }}
damping = {{ motion = 2 }}
[body.sheet.obstacle.liver]
body = "liver"
)",
                                       (box.low.x + box.high.x) / 2 - 0.05, box.low.y - 0.005,
                                       (box.low.z + box.high.z) / 2 - 0.05);
  world = must_load(text);
  run(world, 60);
  const ClothBody& sheet = world.cloth_bodies[0];
  const auto lowest_at_tool = [&] {  // of the vertices near the tool's axis, along y
    double y = -1;
    const Vec3d tool = path_at(world.tools[0].path, 1.5).position;
    for (int v = 0; v < sheet.model.count; v++) {
      const Vec3d x(sheet.state->x[std::size_t(v)]);
      if (std::hypot(x.x - tool.x, x.z - tool.z) < 0.008) y = std::max(y, x.y);
    }
    return y;
  };
  const double before = lowest_at_tool();
  run(world, 90);
  EXPECT_NEAR(lowest_at_tool() - before, 0.008, 0.004) << "m: the cloth follows the dent of 10 mm";
}

}  // namespace
}  // namespace turgor
