#include "turgor/sim/bodies/cloth/cloth_support.hpp"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/cloth/measure.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

/// Downward displacement of the block's top: mean, least and largest [m].
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

// ------------------------------------------------------------ a sheet on a block

// A block carries the sheet's weight and sinks by p L / E.
TEST(ClothSupport, HeavySheetMatchesYoungsModulus) {
  World world = must_load(std::string(kPad) + kSheetOnPad);
  run(world, 240);
  const SfemBody& pad = world.sfem_bodies[0];
  const double pressure = 10 * kGravity, weight = pressure * 0.06 * 0.06;
  const Vec3d body_force = total_force(pad.press->load),
              cloth_force = mean_of_last(world.cloth_bodies[0].obstacles[0].force, 60);
  EXPECT_NEAR(cloth_force.z, -weight, 0.01 * weight) << "N, on the cloth";
  EXPECT_NEAR(body_force.z, -weight, 0.01 * weight) << "N, on the body";
  EXPECT_LT(std::hypot(body_force.x, body_force.y), 0.01 * weight);
  const Sinking top = sinking(pad);
  const double expected = pressure * 0.03 / 5e3;
  EXPECT_NEAR(top.mean, expected, 0.01 * expected) << "m, p L / E";
  // The weight is distributed by triangles: a corner with two of them carries twice the load of a corner with
  // one.
  EXPECT_NEAR(top.least, expected, 0.15 * expected);
  EXPECT_NEAR(top.most, expected, 0.15 * expected);
}

// The middle of a wide block sinks by p L / M with the oedometric modulus M.
TEST(ClothSupport, WideBlockMatchesOedometer) {
  const double young = 5e3, nu = 0.3, modulus = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  // Only the middle of a wide block counts: far from its sides, tissue cannot expand laterally.
  World world = must_load(
      std::string(kPad) + kSheetOnPad,
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

// The displacement under the sheet solves K u = f.
TEST(ClothSupport, DisplacementSolvesKuEqualsF) {
  for (const char* how : {"body.pad.precision=double", "body.pad.rotations=true", "body.pad.memory=0.004"}) {
    World world = must_load(std::string(kPad) + kSheetOnPad, {"body.pad.poisson=0.3", how});
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

// A body and the floor share the weight of an overhanging sheet.
TEST(ClothSupport, BodyAndFloorShareWeight) {
  World world = must_load(
      std::string(kPad) + kSheetOnPad + "[body.sheet.obstacle.floor]\nplane = { through = [0, 0, 0] }\n",
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

// ------------------------------------------------------------ staggered coupling

// A sheet too heavy for a plain exchange of forces still settles.
TEST(ClothSupport, VeryHeavySheetSettles) {
  // A static settlement above g h²/4 = 0.7 mm makes the plain exchange of forces unstable; this one is 8.8
  // mm.
  World world =
      must_load(std::string(kPad) + kSheetOnPad, {"body.pad.young=1e3", "body.sheet.fabric.density=30"});
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
  EXPECT_LT(early, 1.6 * expected) << "m; a sheet dropped on a spring sinks twice as deep";
  EXPECT_NEAR(least, expected, 0.02 * expected);
  EXPECT_LT(most - least, 1e-3 * expected) << "m, in the last 100 of 1000 frames";
  EXPECT_LT(kinetic, 1e-6 * world.cloth_bodies[0].model.total_mass * kGravity * expected) << "J";
  EXPECT_LT(pad.press->load.relaxation, 0.2) << "per change and frame";
}

// A corotational block carries the sheet like a linear one.
TEST(ClothSupport, CorotationalBlockCarriesSheet) {
  World plain = must_load(std::string(kPad) + kSheetOnPad);
  World turned = must_load(std::string(kPad) + kSheetOnPad, {"body.pad.rotations=true"});
  run(plain, 240), run(turned, 240);
  const SfemBody& pad = turned.sfem_bodies[0];
  ASSERT_TRUE(pad.turning);
  EXPECT_EQ(pad.turning->unconverged, 0);
  double difference = 0;
  for (std::size_t n = 0; n < pad.model.green.surface_count; n++) {
    const auto v = std::size_t(pad.model.green.nodes[n]);
    difference = std::max(difference, norm(pad.free.now[v] - plain.sfem_bodies[0].free.now[v]));
  }
  EXPECT_LT(difference, 0.05 * sinking(pad).mean) << "m: at a strain of 2 % the rotations are small";
  EXPECT_GT(difference, 0);
}

// The impulse on the body equals the loss of the cloth's momentum.
TEST(ClothSupport, MomentumIsConserved) {
  World world = must_load(std::string(kPad) + kSheetOnPad);
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
    // Damping of motion also takes momentum: 0.2/s.
    EXPECT_LT(norm(lost - got), 0.01 * norm(lost) + 0.005 * mass * 0.3) << "N·s, frame " << n;
    largest = std::max(largest, norm(got));
  }
  EXPECT_GT(largest, mass * 0.1) << "N·s: it has fallen on the block";
}

// The body recovers its shape after the cloth is lifted.
TEST(ClothSupport, BodyRecoversAfterLift) {
  World world = must_load(std::string(kPad) + kSheetOnPad +
                          "[body.sheet.hold.all]\nbox = [[-1, -1, -1], [1, 1, 1]]\nstart = 2\npath = [[2, 0, "
                          "0, 0], [2.3, 0, 0, 0.1]]\n");
  run(world, 120);
  EXPECT_GT(sinking(world.sfem_bodies[0]).mean, 5e-4);
  run(world, 60);
  EXPECT_LT(sinking(world.sfem_bodies[0]).most, 1e-6);
}

// Body and sheet have the same bits on 1, 2 and 8 threads.
TEST(ClothSupport, EqualBitsOnAnyThreads) {
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    World world = must_load(std::string(kPad) + kSheetOnPad, {"body.pad.precision=single"}, exec);
    run(world, 60, exec);
    const auto& u = world.sfem_bodies[0].press->displacement;
    hashes.insert(hash_bytes(u.data(), u.size() * sizeof u[0],
                             cloth::state_hash(world.cloth_bodies[0].model, world.cloth_bodies[0].state)));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

// ------------------------------------------------------------ tools

// A tool touches the body at the surface that the cloth has lowered.
TEST(ClothSupport, ToolTouchesLoweredSurface) {
  const auto pressed_by = [](double depth, bool with_sheet) {
    const std::string tool = fmt::format(
        "[tool.finger]\nbody = \"pad\"\nshape = {{ sphere = 0.01 }}\npress = {{ at_fraction = [0.5, 0.5, 1], "
        "depth = {}, start = 2, duration = 0.2, hold = 1 }}\n",
        depth);
    World world =
        must_load(kPad + std::string(with_sheet ? kSheetOnPad : "") + tool, {"body.pad.patch.radius=0.03"});
    run(world, 180);
    EXPECT_GT(world.tools[0].samples.back().contacts, 0);
    return norm(world.tools[0].samples.back().force);
  };
  const double settlement = 10 * kGravity * 0.03 / 5e3;
  const double alone = pressed_by(0.004, false), through = pressed_by(0.004, true),
               deeper = pressed_by(0.004 + settlement, true);
  EXPECT_LT(through, 0.9 * alone) << "N; the surface lies " << settlement << " m deeper under the sheet";
  EXPECT_NEAR(deeper, alone, 0.1 * alone) << "N, with the tool deeper by the settlement";
}

// A ball that nothing fixes, borne by a sheet with sweeps, is warned of. It is not on a sheet that moves
// together with it, and neither is a ball below a sheet.
TEST(ClothSupport, BorneFreeBodyIsWarnedOf) {
  const std::string scene = R"(
[world]
gravity = [0, 0, -9.81]
[body.sheet]
model = "cloth"
sheet = { corner = [-0.1, -0.1, 0], side = [0.2, 0, 0], up = [0, 0.2, 0], columns = 16, rows = 16 }
fabric = { density = 0.3 }
[body.sheet.obstacle.ball]
body = "ball"
[body.ball]
model = "rigid"
shape = { sphere = 0.02 }
at = [0, 0, 0.0205]
mass = 0.05
)";
  const std::vector<std::string> sweeps{"body.sheet.solver.method=sweeps"};
  World borne = must_load(scene, sweeps), covered = must_load(scene, sweeps), moved = must_load(scene);
  for (World* world : {&borne, &moved}) world->cloth_bodies[0].obstacles[0].force.assign(3, {0, 0, 0.3});
  covered.cloth_bodies[0].obstacles[0].force.assign(3, {0, 0, -0.3});
  const std::vector<std::string> warnings = cloth_warnings(borne);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("sheet: obstacle.ball: the cloth bears a body that nothing fixes"),
            std::string::npos)
      << warnings[0];
  EXPECT_TRUE(cloth_warnings(covered).empty());
  EXPECT_TRUE(cloth_warnings(moved).empty());
}

}  // namespace
}  // namespace turgor
