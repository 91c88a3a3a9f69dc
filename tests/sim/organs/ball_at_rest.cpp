// A ball that lies on a lattice comes to rest: nothing pushes it sideways, and rolling ends.
#include <cmath>

#include <fmt/format.h>

#include "organs_scene.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A block of voxels of 4 mm in air, 96 mm wide along x and z: 32 mm of fat on bone along y. Its front is at
/// y = -22 mm.
CtVolume wide_fat_ct() {
  CtVolume ct;
  ct.grid.size = {32, 20, 32};
  ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = {-0.062, -0.036, -0.062};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  for (int k = 4; k < 28; k++)
    for (int j = 4; j < 16; j++)
      for (int i = 4; i < 28; i++) ct.at(i, j, k) = j < 12 ? -100 : 1000;
  return ct;
}

/// A ball of 20 mm radius and 50 g above the block, 1 mm and 0.5 mm beside the axis of the block.
World ball_world(const Exec& exec, double speed, const char* partial_cells) {
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "fat.nii", wide_fat_ct()));
  const Result<Scene> scene = parse_scene(
      fmt::format("[world]\nduration = 20\ngravity = [0, 9.81, 0]\n[body.fat]\nmodel = \"lattice\"\nct = "
                  "\"fat.nii\"\nblock = 2\nfixed = \"bone\"\ngravity = false\nskin.tension = 0\n"
                  "tissue.partial_cells = {}\n[body.ball]\n"
                  "model = \"rigid\"\nshape = {{ sphere = 0.02 }}\nat = [0.001, -0.0425, 0.0005]\nmass = "
                  "0.05\nvelocity = [{}, 0, 0]\n[contact.rest]\nbetween = [\"ball\", \"fat\"]\nfriction = "
                  "0.5\nsites = 200\n",
                  partial_cells, speed),
      folder / "ball.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// The part of a vector across gravity.
double sideways(Vec3d a) { return std::hypot(a.x, a.z); }

/// A ball that falls on flat tissue, or rolls onto it, comes to rest within `distance` of the axis [m], and
/// no force pushes it sideways.
void expect_rest_of_ball(const char* partial_cells, double distance) {
  const Exec exec(2);
  constexpr double kWeight = 0.05 * 9.81;
  for (const double speed : {0.0, 0.02}) {
    World world = ball_world(exec, speed, partial_cells);
    test::advance(exec, world, 150);
    double most = 0, fastest = 0;
    for (int n = 0; n < 30; n++) {
      test::advance(exec, world, 1);
      most = std::max(most, sideways(world.coupling.contacts[0].samples.back().force));
      fastest = std::max(fastest, sideways(world.rigid_bodies[0].state.velocity));
    }
    const Vec3d at = world.rigid_bodies[0].state.center;
    std::printf("sideways %.2g of the weight, %.2g mm/s, %.3f mm from the axis\n", most / kWeight,
                1e3 * fastest, 1e3 * sideways(at));
    EXPECT_LT(most, 1e-3 * kWeight);
    EXPECT_LT(fastest, 1e-3);
    EXPECT_LT(sideways(at), distance);
  }
}

// On whole cells, a ball rests within half a cell.
TEST(BallAtRest, ComesToRest) { expect_rest_of_ball("false", 0.004); }

// On partial cells, it rolls into the neighbor cell and rests there (partial-cells.md, Limits).
TEST(BallAtRest, OnPartialCells_ComesToRest) { expect_rest_of_ball("true", 0.0105); }

}  // namespace
}  // namespace turgor
