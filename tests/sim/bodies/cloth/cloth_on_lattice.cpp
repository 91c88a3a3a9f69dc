// A sheet on a lattice: the weight on both bodies, and the settlement.
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
fabric = { law = "springs", density = 10 }
solver = { method = "sweeps" }
collision = { self = false, thickness = 0.0015 }
wind = { density = 0 }
[body.sheet.obstacle.fat]
body = "fat"
)",
                     overrides, exec);
}

/// Mean displacement of the front nodes in the block's middle, and their initial height above fixed nodes
/// [m].
struct FatUnderSheet {
  double down = 0, height = 0;
};
FatUnderSheet middle_of(const LatticeBody& body) {
  const lattice::Model& model = body.model;
  FatUnderSheet found;
  int count = 0;
  for (int i = 0; i < model.anatomy.lattice.size.x; i++)
    for (int k = 0; k < model.anatomy.lattice.size.z; k++) {
      const Vec3d x = point_at(model.anatomy.grid, {double(i), 0, double(k)});
      if (std::max(std::abs(x.x), std::abs(x.z)) > 0.025) continue;
      int front = 0, fixed = 0;
      const auto slot = [&](int j) { return std::size_t(node_slot(model.anatomy.lattice, i, j, k)); };
      while (!lattice::is_body(model.anatomy.tissue[slot(front)])) front++;
      for (fixed = front; model.anatomy.inverse_mass[slot(fixed)] > 0;) fixed++;
      found.down += dot(model.anatomy.grid.axes * Vec3d(body.state->motion.u[slot(front)]), Vec3d{0, 1, 0});
      found.height += (fixed - front) * model.anatomy.grid.spacing.y;
      count++;
    }
  return {found.down / count, found.height / count};
}

/// A sheet settles on a lattice with whole or partial cells, whose surface then moves by less than `drift` of
/// the column's compression.
void expect_column_below_sheet(const char* partial_cells, double drift) {
  const Exec exec(2);
  World world = sheet_on_lattice(
      test::fresh_folder(), exec,
      {"body.sheet.solver.method=blocks", std::string("body.fat.tissue.partial_cells=") + partial_cells});
  double most = 0, late_least = 1, late_most = 0;
  for (int n = 0; n < 360; n++) {
    run(world, 1, exec);
    const double down = middle_of(world.lattice_bodies[0]).down;
    most = std::max(most, down);
    // settling decays slowly: rounding moves the range of frames 180 to 280 by 3 % around the bound below
    if (n >= 260) late_least = std::min(late_least, down), late_most = std::max(late_most, down);
  }
  const double pressure = 10 * kGravity, weight = pressure * 0.128 * 0.128;
  const ClothBody& sheet = world.cloth_bodies[0];
  EXPECT_NEAR(mean_of_last(sheet.obstacles[0].force, 60).y, weight, 0.01 * weight) << "N, on the cloth";
  EXPECT_NEAR(total_force(world.lattice_bodies[0].cloth).y, weight, 0.01 * weight) << "N, on the body";
  // The block is fixed below and 1.6 times as wide as high. Its modulus lies between E of a free column and
  // 1.2 E of a laterally held one (Poisson's ratio 1/4).
  const double column = pressure * middle_of(world.lattice_bodies[0]).height / 5e3;
  EXPECT_GT(late_least, 0.95 * column / 1.2) << "m, of " << column;
  EXPECT_LT(late_most, 1.05 * column) << "m";
  std::printf("partial cells %s: %.3f to %.3f mm of %.3f mm\n", partial_cells, 1e3 * late_least,
              1e3 * late_most, 1e3 * column);
  EXPECT_LT(late_most - late_least, drift * column) << "m, in the last 100 frames";
  EXPECT_LT(most, 2 * column) << "m";
}

// A lattice carries the sheet's weight and sinks between the free and the laterally held column.
TEST(ClothOnLattice, HeavySheetMatchesColumn) { expect_column_below_sheet("false", 1e-3); }

// The same with partial cells. The sheet keeps them moving a little (partial-cells.md, Limits).
TEST(ClothOnLattice, HeavySheetOnPartialCells) { expect_column_below_sheet("true", 2.5e-3); }

// A surface in partial cells bears the weight of a resting sheet: forces act where the surface moves. Forces
// on its outermost nodes let the sheet flutter, and lacked 7e-4 of its weight.
TEST(ClothOnLattice, PartialCellsBearWeight) {
  World world = sheet_on_lattice(test::fresh_folder(), Exec(1),
                                 {"body.sheet.solver.method=blocks", "body.fat.tissue.partial_cells=true"});
  run(world, 120);
  const double weight = 10 * kGravity * 0.128 * 0.128;
  EXPECT_NEAR(total_force(world.lattice_bodies[0].cloth).y, weight, 1e-4 * weight) << "N";
  const FatUnderSheet middle = middle_of(world.lattice_bodies[0]);
  const double column = 10 * kGravity * middle.height / 5e3;
  EXPECT_GT(middle.down, 0.95 * column / 1.2) << "m, of " << column;
  EXPECT_LT(middle.down, 1.05 * column) << "m";
}

// A sheet on a lattice has the same bits on 1, 2 and 8 threads.
TEST(ClothOnLattice, EqualBitsOnAnyThreads) {
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

// A sheet and a lattice on a backend exchange the same forces as on the host. The backend is the host with
// shuffled order.
TEST(ClothOnLattice, BackendMatchesHost) {
  const auto run_on = [](bool on_backend) {
    World world = sheet_on_lattice(
        test::fresh_folder(), Exec(1),
        {"body.fat.solver={ ordering = \"colors\", coarse = false }", "body.fat.tissue.partial_cells=false",
         "body.sheet.obstacle.peg.sphere={ center = [0, -0.03, 0.01], radius = 0.012 }"});
    LatticeBody& fat = world.lattice_bodies[0];
    ClothBody& sheet = world.cloth_bodies[0];
    if (on_backend) {
      fat.state.use_backend(lattice::put_on_host<lattice::SeededRun<1>>(fat.model));
      sheet.state.use_backend(cloth::put_on_host<lattice::SeededRun<2>>(sheet.model));
    }
    run(world, 12);
    return world;
  };
  const World host = run_on(false), device = run_on(true);
  const ClothBody &a = host.cloth_bodies[0], &b = device.cloth_bodies[0];
  for (std::size_t o = 0; o < 2; o++) {
    EXPECT_GT(norm(a.obstacles[o].force[11]), 0.01) << "N of " << a.obstacles[o].name;
    for (const std::size_t n : {2, 5, 11})
      EXPECT_LT(norm(a.obstacles[o].force[n] - b.obstacles[o].force[n]),
                1e-2 * norm(a.obstacles[o].force[n]) + 1e-6)
          << "N of " << a.obstacles[o].name << " in frame " << n;
  }
  const Vec3d host_force = total_force(host.lattice_bodies[0].cloth);
  EXPECT_LT(norm(total_force(device.lattice_bodies[0].cloth) - host_force), 1e-2 * norm(host_force)) << "N";
}

// The momentum of a floating lattice equals the impulse of the sheet.
TEST(ClothOnLattice, FloatingLatticeGainsMomentum) {
  World world =
      sheet_on_lattice(test::fresh_folder(), Exec(1),
                       {"body.fat.fixed=none", "body.fat.solver={ sweeps = 200, damping = 0 }",
                        "body.fat.tissue={ law = \"springs\", fat = 5e3, bone = 5e3, volume = 1 }"});
  const LatticeBody& fat = world.lattice_bodies[0];
  const auto momentum = [&fat] {  // [kg·m/s]
    Vec3d sum;
    for (std::size_t s = 0; s < fat.model.anatomy.inverse_mass.size(); s++)
      if (fat.model.anatomy.inverse_mass[s] > 0)
        sum += Vec3d(fat.state->motion.v[s]) / double(fat.model.anatomy.inverse_mass[s]);
    return fat.model.anatomy.grid.axes * sum;
  };
  double given = 0;
  for (int n = 0; n < 30; n++) {
    given += total_force(fat.cloth).y * world.dt;
    run(world, 1);
    EXPECT_NEAR(momentum().y, given, 0.02 * given + 1e-6) << "kg·m/s, frame " << n;
  }
  EXPECT_GT(given, 0.2) << "N·s: half a second of a weight of 1.6 N";
}

}  // namespace
}  // namespace turgor
