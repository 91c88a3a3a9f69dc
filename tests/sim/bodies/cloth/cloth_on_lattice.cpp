// A sheet that lies on a lattice: both sides of the weight, and how far the body gives way.
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/cloth/on_host.hpp"
#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/sim/bodies/cloth/cloth_support.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

/// A sheet that covers the middle of the fat.
World sheet_on_lattice(const std::filesystem::path& folder, const Exec& exec = Exec(1),
                       const std::vector<std::string>& overrides = {}) {
  return fat_on_bone(folder, R"(
tissue = { fat = 5e3, poisson = 0.25 }
[body.sheet]
model = "cloth"
sheet = { corner = [-0.064, -0.022, -0.064], side = [0, 0, 0.128], up = [0.128, 0, 0], columns = 40, rows = 40 }
fabric = { density = 10 }
collision = { self = false, thickness = 0.0015 }
wind = { density = 0 }
[body.sheet.obstacle.fat]
body = "fat"
)",
                     overrides, exec);
}

/// How far the front of the block's middle has gone, and its first height above fixed nodes [m].
struct FatUnderSheet {
  double down = 0, height = 0;
};
FatUnderSheet middle_of(const LatticeBody& body) {
  const lattice::Model& model = body.model;
  FatUnderSheet found;
  int count = 0;
  for (int i = 0; i < model.lattice.size.x; i++)
    for (int k = 0; k < model.lattice.size.z; k++) {
      const Vec3d x = point_at(model.grid, {double(i), 0, double(k)});
      if (std::max(std::abs(x.x), std::abs(x.z)) > 0.025) continue;
      int front = 0, fixed = 0;
      const auto slot = [&](int j) { return std::size_t(node_slot(model.lattice, i, j, k)); };
      while (!lattice::is_body(model.tissue[slot(front)])) front++;
      for (fixed = front; model.inverse_mass[slot(fixed)] > 0;) fixed++;
      found.down += dot(model.grid.axes * Vec3d(body.state->u[slot(front)]), Vec3d{0, 1, 0});
      found.height += (fixed - front) * model.grid.spacing.y;
      count++;
    }
  return {found.down / count, found.height / count};
}

TEST(cloth_on_lattice,
     a_lattice_bears_the_sheets_weight_and_sinks_by_pressure_times_height_over_its_modulus) {
  const Exec exec(2);
  World world = sheet_on_lattice(test::fresh_folder(), exec, {"body.sheet.solver.method=blocks"});
  double most = 0, late_least = 1, late_most = 0;
  for (int n = 0; n < 280; n++) {
    run(world, 1, exec);
    const double down = middle_of(world.lattice_bodies[0]).down;
    most = std::max(most, down);
    if (n >= 180) late_least = std::min(late_least, down), late_most = std::max(late_most, down);
  }
  const double pressure = 10 * kGravity, weight = pressure * 0.128 * 0.128;
  const ClothBody& sheet = world.cloth_bodies[0];
  EXPECT_NEAR(mean_of_last(sheet.obstacles[0].force, 60).y, weight, 0.01 * weight) << "N, the cloth's side";
  EXPECT_NEAR(total_force(world.lattice_bodies[0].cloth).y, weight, 0.01 * weight) << "N, the body's side";
  // Held below and 1.6 times as wide as high on each side: between the moduli of a free column, E, and of one
  // whose sides are held, 1.2 E for Poisson's ratio of 1/4.
  const double column = pressure * middle_of(world.lattice_bodies[0]).height / 5e3;
  EXPECT_GT(late_least, 0.95 * column / 1.2) << "m, of " << column;
  EXPECT_LT(late_most, 1.05 * column) << "m";
  EXPECT_LT(late_most - late_least, 1e-3 * column) << "m, in the last 100 frames";
  EXPECT_LT(most, 2 * column) << "m";
}

TEST(cloth_on_lattice, equal_bits_of_a_sheet_on_a_lattice_on_1_2_and_8_threads) {
  const auto folder = test::fresh_folder();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8}) {
    World world = sheet_on_lattice(folder, Exec(threads));
    run(world, 30, Exec(threads));
    EXPECT_FALSE(world.lattice_bodies[0].cloth.force.empty());
    hashes.insert(lattice::state_hash(world.lattice_bodies[0].model, world.lattice_bodies[0].state) ^
                  cloth::state_hash(world.cloth_bodies[0].model, world.cloth_bodies[0].state));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

/// In place of a GPU: the host, in a shuffled order.
TEST(cloth_on_lattice, a_sheet_and_a_lattice_that_step_elsewhere_press_each_other_as_they_do_here) {
  const auto run_on = [](bool elsewhere) {
    World world =
        sheet_on_lattice(test::fresh_folder(), Exec(1),
                         {"body.fat.solver={ schedule = \"colours\", coarse = false }",
                          "body.sheet.obstacle.peg.sphere={ centre = [0, -0.03, 0.01], radius = 0.012 }"});
    LatticeBody& fat = world.lattice_bodies[0];
    ClothBody& sheet = world.cloth_bodies[0];
    if (elsewhere) {
      fat.state.step_on(lattice::put_on_host<lattice::SeededRun<1>>(fat.model));
      sheet.state.step_on(cloth::put_on_host<lattice::SeededRun<2>>(sheet.model));
    }
    run(world, 12);
    return world;
  };
  const World here = run_on(false), there = run_on(true);
  const ClothBody &a = here.cloth_bodies[0], &b = there.cloth_bodies[0];
  for (std::size_t o = 0; o < 2; o++) {
    EXPECT_GT(norm(a.obstacles[o].force[11]), 0.01) << "N of " << a.obstacles[o].name;
    for (const std::size_t n : {2, 5, 11})
      EXPECT_LT(norm(a.obstacles[o].force[n] - b.obstacles[o].force[n]),
                1e-2 * norm(a.obstacles[o].force[n]) + 1e-6)
          << "N of " << a.obstacles[o].name << " in frame " << n;
  }
  const Vec3d borne = total_force(here.lattice_bodies[0].cloth);
  EXPECT_LT(norm(total_force(there.lattice_bodies[0].cloth) - borne), 1e-2 * norm(borne)) << "N";
}

TEST(cloth_on_lattice, a_lattice_that_floats_gets_the_momentum_of_what_it_feels) {
  World world =
      sheet_on_lattice(test::fresh_folder(), Exec(1),
                       {"body.fat.fixed=none", "body.fat.solver={ sweeps = 200, damping = 0 }",
                        "body.fat.tissue={ law = \"springs\", fat = 5e3, bone = 5e3, volume = 1 }"});
  const LatticeBody& fat = world.lattice_bodies[0];
  const auto momentum = [&fat] {  // [kg·m/s]
    Vec3d sum;
    for (std::size_t s = 0; s < fat.model.inverse_mass.size(); s++)
      if (fat.model.inverse_mass[s] > 0) sum += Vec3d(fat.state->v[s]) / double(fat.model.inverse_mass[s]);
    return fat.model.grid.axes * sum;
  };
  double given = 0;
  for (int n = 0; n < 30; n++) {
    given += total_force(fat.cloth).y * world.dt;
    run(world, 1);
    EXPECT_NEAR(momentum().y, given, 0.02 * given + 1e-6) << "kg·m/s, frame " << n;
  }
  EXPECT_GT(given, 0.2) << "of the weight of 1.6 N in half a second";
}

}  // namespace
}  // namespace turgor
