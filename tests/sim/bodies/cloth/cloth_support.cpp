#include "turgor/sim/bodies/cloth/cloth_support.hpp"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/block_scene.hpp"
#include "sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/cloth/measure.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

constexpr double kGravity = 9.81;

/// A heavy sheet that covers it, 3 mm above.
constexpr const char* kSheet = R"(
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0.033], side = [0.06, 0, 0], up = [0, 0.06, 0], columns = 24, rows = 24 }
fabric = { density = 10 }
collision = { self = false, thickness = 0.001 }
wind = { density = 0 }
[body.sheet.obstacle.pad]
body = "pad"
)";

/// Of the block's top, downwards: mean, least and most [m].
struct Sinking {
  double mean = 0, least = 1, most = 0;
};
Sinking sinking(const SfemBody& body) {
  Sinking found;
  int count = 0;
  for (std::size_t v = 0; v < body.model.body.mesh.vertices.size(); v++) {
    if (body.model.body.mesh.vertices[v].z < 0.0299) continue;
    const double down = -body.press->displacement[v].z;
    found.mean += down, count++;
    found.least = std::min(found.least, down), found.most = std::max(found.most, down);
  }
  found.mean /= count;
  return found;
}

// ------------------------------------------------------------ a sheet that lies on a block

TEST(cloth_support, an_organ_bears_the_sheets_weight_and_sinks_by_pressure_times_height_over_youngs_modulus) {
  World world = must_load(std::string(kPad) + kSheet);
  run(world, 240);
  const SfemBody& pad = world.sfem_bodies[0];
  const double pressure = 10 * kGravity, weight = pressure * 0.06 * 0.06;
  const Vec3d felt = total_force(pad.press->load),
              pushed = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
  EXPECT_NEAR(pushed.z, -weight, 0.01 * weight) << "N, the cloth's side";
  EXPECT_NEAR(felt.z, -weight, 0.01 * weight) << "N, the body's side";
  EXPECT_LT(std::hypot(felt.x, felt.y), 0.01 * weight);
  const Sinking top = sinking(pad);
  const double expected = pressure * 0.03 / 5e3;
  EXPECT_NEAR(top.mean, expected, 0.01 * expected) << "m, p L / E";
  // The weight comes to triangles: a corner that has two of them bears twice what one with one bears.
  EXPECT_NEAR(top.least, expected, 0.15 * expected);
  EXPECT_NEAR(top.most, expected, 0.15 * expected);
}

TEST(cloth_support, with_its_sides_held_the_block_sinks_by_the_oedometric_modulus) {
  const double young = 5e3, nu = 0.3, modulus = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  // Nothing but the middle of a wide block: far from its sides, tissue cannot give way sideways.
  World world = must_load(
      std::string(kPad) + kSheet,
      {"body.pad.poisson=0.3", "body.pad.block={ size = [0.3, 0.3, 0.03], count = [20, 20, 3] }",
       "body.sheet.sheet={ corner = [0, 0, 0.033], side = [0.3, 0, 0], up = [0, 0.3, 0], columns = 40, rows "
       "= 40 }"});
  run(world, 240);
  const SfemBody& pad = world.sfem_bodies[0];
  double middle = 0;
  int count = 0;
  for (std::size_t v = 0; v < pad.model.body.mesh.vertices.size(); v++) {
    const Vec3d x = pad.model.body.mesh.vertices[v];
    if (x.z < 0.0299 || std::abs(x.x - 0.15) > 0.05 || std::abs(x.y - 0.15) > 0.05) continue;
    middle -= pad.press->displacement[v].z, count++;
  }
  const double expected = 10 * kGravity * 0.03 / modulus;
  EXPECT_NEAR(middle / count, expected, 0.02 * expected) << "m, p L / M";
}

TEST(cloth_support, the_displacement_is_the_solution_of_k_u_equals_f) {
  for (const char* how : {"body.pad.precision=double", "body.pad.rotations=true", "body.pad.memory=0.004"}) {
    World world = must_load(std::string(kPad) + kSheet, {"body.pad.poisson=0.3", how});
    run(world, 60);
    SfemBody& pad = world.sfem_bodies[0];
    EXPECT_EQ(pad.facts.on_demand, std::string_view(how).find("memory") != std::string_view::npos);
    ASSERT_TRUE(sfem::factorize(Exec(1), pad.model));
    std::vector<double> u(3 * pad.model.vertex.size());
    for (const auto& [vertex, force] : pad.press->load.force)
      if (const int row = pad.model.free_node[std::size_t(vertex)]; row >= 0)
        for (int axis = 0; axis < 3; axis++) u[std::size_t(3 * row + axis)] += force[axis];
    sfem::solve(*pad.model.factor, u);
    double largest = 0, difference = 0;
    for (std::size_t n = 0; n < pad.model.green.surface_count; n++) {
      const auto v = std::size_t(pad.model.green.nodes[n]), row = std::size_t(pad.model.free_node[v]);
      const Vec3d exact{u[3 * row], u[3 * row + 1], u[3 * row + 2]};
      largest = std::max(largest, norm(exact));
      difference = std::max(difference, norm(pad.press->displacement[v] - exact));
    }
    EXPECT_GT(largest, 1e-4);
    EXPECT_LT(difference, 1e-6 * largest) << how;
  }
}

TEST(cloth_support, body_and_floor_share_the_weight_of_a_sheet_that_hangs_over) {
  World world = must_load(
      std::string(kPad) + kSheet + "[body.sheet.obstacle.floor]\nplane = { through = [0, 0, 0] }\n",
      {"body.sheet.sheet={ corner = [-0.07, 0, 0.033], side = [0.2, 0, 0], up = [0, 0.06, 0], columns = 80, "
       "rows = 24 }",
       "body.sheet.fabric.density=2"});
  run(world, 300);
  const ClothBody& sheet = world.cloth_bodies[0];
  const double weight = 2 * kGravity * 0.2 * 0.06;
  const Vec3d pad = mean_of_last(sheet.obstacles[0].force, 60),
              floor = mean_of_last(sheet.obstacles[1].force, 60);
  EXPECT_GT(-pad.z, 0.25 * weight);
  EXPECT_GT(-floor.z, 0.1 * weight);
  EXPECT_NEAR((pad + floor).z, -weight, 0.01 * weight) << pad.z << " N and " << floor.z << " N";
  EXPECT_NEAR(total_force(world.sfem_bodies[0].press->load).z, pad.z, 0.01 * weight);
}

/// A sheet that covers the middle of 40 mm of fat on bone, which gravity holds down from the front (+y).
World sheet_on_lattice(const std::filesystem::path& folder, const Exec& exec = Exec(1),
                       const std::vector<std::string>& overrides = {}) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text = R"(
[world]
gravity = [0, 9.81, 0]
[body.fat]
model = "lattice"
ct = "block.nii"
block = 2
gravity = false
skin = false
tissue = { fat = 5e3, poisson = 0.25 }
[body.sheet]
model = "cloth"
sheet = { corner = [-0.064, -0.022, -0.064], side = [0, 0, 0.128], up = [0.128, 0, 0], columns = 40, rows = 40 }
fabric = { density = 10 }
collision = { self = false, thickness = 0.0015 }
wind = { density = 0 }
[body.sheet.obstacle.fat]
body = "fat"
)";
  const Result<Scene> scene = parse_scene(text, folder / "sheet.toml", overrides);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
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
      found.down += dot(model.grid.axes * Vec3d(body.state.u[slot(front)]), Vec3d{0, 1, 0});
      found.height += (fixed - front) * model.grid.spacing.y;
      count++;
    }
  return {found.down / count, found.height / count};
}

TEST(cloth_support, a_lattice_bears_the_sheets_weight_and_sinks_by_pressure_times_height_over_its_modulus) {
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

TEST(cloth_support, equal_bits_of_a_sheet_on_a_lattice_on_1_2_and_8_threads) {
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

TEST(cloth_support, a_lattice_that_floats_gets_the_momentum_of_what_it_feels) {
  World world =
      sheet_on_lattice(test::fresh_folder(), Exec(1),
                       {"body.fat.fixed=none", "body.fat.solver={ sweeps = 200, damping = 0 }",
                        "body.fat.tissue={ law = \"springs\", fat = 5e3, bone = 5e3, volume = 1 }"});
  const LatticeBody& fat = world.lattice_bodies[0];
  const auto momentum = [&fat] {  // [kg·m/s]
    Vec3d sum;
    for (std::size_t s = 0; s < fat.model.inverse_mass.size(); s++)
      if (fat.model.inverse_mass[s] > 0) sum += Vec3d(fat.state.v[s]) / double(fat.model.inverse_mass[s]);
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

// ------------------------------------------------------------ by turns, and yet at rest

TEST(cloth_support, a_sheet_far_heavier_than_the_coupling_alone_would_bear_comes_to_rest) {
  // A static sinking of more than g h²/4 = 0.7 mm makes the plain exchange of forces unstable; here 8.8 mm.
  World world = must_load(std::string(kPad) + kSheet, {"body.pad.young=1e3", "body.sheet.fabric.density=30"});
  const SfemBody& pad = world.sfem_bodies[0];
  const double expected = 30 * kGravity * 0.03 / 1e3;
  double early = 0, least = 1, most = 0, kinetic = 0;
  for (int n = 0; n < 1000; n++) {
    run(world, 1);
    if (!pad.press) continue;
    const double mean = sinking(pad).mean;
    if (n < 300) early = std::max(early, mean);
    if (n < 900) continue;
    least = std::min(least, mean), most = std::max(most, mean);
    kinetic = std::max(
        kinetic,
        cloth::energy(world.cloth_bodies[0].model, world.cloth_bodies[0].state, world.gravity).kinetic);
  }
  EXPECT_LT(early, 1.6 * expected) << "m; a sheet dropped on a spring goes twice as deep";
  EXPECT_NEAR(least, expected, 0.02 * expected);
  EXPECT_LT(most - least, 1e-3 * expected) << "m, in the last 100 of 1000 frames";
  EXPECT_LT(kinetic, 1e-6 * world.cloth_bodies[0].model.total_mass * kGravity * expected) << "J";
  EXPECT_LT(pad.press->load.part, 0.2) << "of a change a frame";
}

TEST(cloth_support, turned_elements_bear_the_sheet_as_well) {
  World plain = must_load(std::string(kPad) + kSheet);
  World turned = must_load(std::string(kPad) + kSheet, {"body.pad.rotations=true"});
  run(plain, 240), run(turned, 240);
  const SfemBody& pad = turned.sfem_bodies[0];
  ASSERT_TRUE(pad.turning);
  EXPECT_EQ(pad.turning->unconverged, 0);
  double difference = 0;
  for (std::size_t n = 0; n < pad.model.green.surface_count; n++) {
    const auto v = std::size_t(pad.model.green.nodes[n]);
    difference = std::max(difference, norm(pad.free.now[v] - plain.sfem_bodies[0].free.now[v]));
  }
  EXPECT_LT(difference, 0.05 * sinking(pad).mean) << "m: of a block pressed by 2 % little turns";
  EXPECT_GT(difference, 0);
}

TEST(cloth_support, what_the_cloth_loses_in_momentum_the_body_gets) {
  World world = must_load(std::string(kPad) + kSheet);
  ClothBody& sheet = world.cloth_bodies[0];
  const double mass = sheet.model.total_mass;
  double largest = 0;
  for (int n = 0; n < 30; n++) {
    const Vec3d before = cloth::momentum(sheet.model, sheet.state);
    run(world, 1);
    const Vec3d got = sheet.obstacles[0].force.back() * world.dt;
    Vec3d spread;
    for (const auto& [vertex, force] : sheet.obstacles[0].support->force) spread += force * world.dt;
    EXPECT_LT(norm(spread - got), 1e-5 * (norm(got) + 1e-9)) << "frame " << n;
    const Vec3d lost = before + world.gravity * (mass * world.dt) - cloth::momentum(sheet.model, sheet.state);
    // Damping of motion takes its part, too: 0.2/s.
    EXPECT_LT(norm(lost - got), 0.01 * norm(lost) + 0.005 * mass * 0.3) << "N·s, frame " << n;
    largest = std::max(largest, norm(got));
  }
  EXPECT_GT(largest, mass * 0.1) << "N·s: it has fallen on the block";
}

TEST(cloth_support, when_the_cloth_is_gone_the_body_rises_again) {
  World world = must_load(std::string(kPad) + kSheet +
                          "[body.sheet.hold.all]\nbox = [[-1, -1, -1], [1, 1, 1]]\nstart = 2\npath = [[2, 0, "
                          "0, 0], [2.3, 0, 0, 0.1]]\n");
  run(world, 120);
  EXPECT_GT(sinking(world.sfem_bodies[0]).mean, 5e-4);
  run(world, 60);
  EXPECT_LT(sinking(world.sfem_bodies[0]).most, 1e-6);
}

TEST(cloth_support, equal_bits_on_1_2_and_8_threads) {
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    World world = must_load(std::string(kPad) + kSheet, {"body.pad.precision=single"}, exec);
    run(world, 60, exec);
    const auto& u = world.sfem_bodies[0].press->displacement;
    hashes.insert(hash_bytes(u.data(), u.size() * sizeof u[0],
                             cloth::state_hash(world.cloth_bodies[0].model, world.cloth_bodies[0].state)));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

// ------------------------------------------------------------ tools, and other models

TEST(cloth_support, a_tool_meets_the_body_where_the_cloth_has_pressed_it) {
  const auto pressed_by = [](double depth, bool with_sheet) {
    const std::string tool = fmt::format(
        "[tool.finger]\nbody = \"pad\"\nshape = {{ sphere = 0.01 }}\npress = {{ at_fraction = [0.5, 0.5, 1], "
        "depth = {}, start = 2, duration = 0.2, hold = 1 }}\n",
        depth);
    World world =
        must_load(kPad + std::string(with_sheet ? kSheet : "") + tool, {"body.pad.patch.radius=0.03"});
    run(world, 180);
    EXPECT_GT(world.tools[0].samples.back().contacts, 0);
    return norm(world.tools[0].samples.back().force);
  };
  const double sunk = 10 * kGravity * 0.03 / 5e3;
  const double alone = pressed_by(0.004, false), through = pressed_by(0.004, true),
               deeper = pressed_by(0.004 + sunk, true);
  EXPECT_LT(through, 0.9 * alone) << "N; the surface lies " << sunk << " m deeper under the sheet";
  EXPECT_NEAR(deeper, alone, 0.1 * alone) << "N, the tool as much deeper";
}

/// On chains with the shape of the pad.
std::string on_chains() {
  return std::string(kPad) + "[body.chains]\nmodel = \"rhombus\"\nsurface_of = \"pad\"\n" + kSheet;
}

TEST(cloth_support, chains_bear_the_sheets_weight_and_sink_as_a_half_space_under_an_even_square) {
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
    EXPECT_NEAR(mean_of_last(sheet.obstacles[0].force, 60).z, -weight, 0.01 * weight)
        << "N, the cloth's side";
    const Vec3d felt = total_force(chains.cloth);
    EXPECT_NEAR(felt.z, -weight, 0.01 * weight) << "N, the chains' side";
    EXPECT_LT(std::hypot(felt.x, felt.y), 0.01 * weight);
    double most = 0;
    for (const Vec3d u : chains.state.displacement) most = std::max(most, -u.z);
    const double expected = 1.1222 * pressure * 0.06 / (5.4e3 / 0.75);
    EXPECT_NEAR(most, expected, 0.05 * expected) << "m: 4 ln(1 + sqrt 2) / pi p B / E*, Boussinesq";
  }
}

TEST(cloth_support, a_liver_of_chains_bears_a_drape_however_it_lies) {
  struct Lie {
    const char *gravity, *sheet, *tissue;
    int down;
  };
  for (const auto& [gravity, sheet, tissue, down] :
       {Lie{"[0, 9.81, 0]", "corner = [-0.05, -0.075, -0.04], side = [0, 0, 0.08], up = [0.1, 0, 0]", "liver",
            1},
        Lie{"[0, 0, -9.81]", "corner = [-0.04, -0.04, 0.055], side = [0.08, 0, 0], up = [0, 0.08, 0]",
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
fabric = {{ density = 1, warp = 100, weft = 100 }}
solver = {{ method = "blocks" }}
collision = {{ self = false, thickness = 0.003 }}
wind = {{ density = 0 }}
damping = {{ motion = 3 }}
[body.sheet.obstacle.liver]
body = "liver"
friction = 1
)",
                                        gravity, tissue, sheet));
    run(world, 180);
    Vec3d felt;
    for (int n = 0; n < 60; n++) run(world, 1), felt += total_force(world.rhombus_bodies[0].cloth) / 60.0;
    const double weight = world.cloth_bodies[0].model.total_mass * kGravity, sign = down == 1 ? 1 : -1;
    const Vec3d pushed = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
    EXPECT_NEAR(sign * pushed[down], weight, 0.01 * weight);
    EXPECT_NEAR(norm(pushed), weight, 0.01 * weight);
    EXPECT_NEAR(norm(felt - pushed), 0, 0.01 * weight);
  }
}

TEST(cloth_support, cloth_lies_in_the_dent_that_a_tool_makes_in_rhombus_chains) {
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
      const Vec3d x(sheet.state.x[std::size_t(v)]);
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
