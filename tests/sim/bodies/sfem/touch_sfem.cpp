#include <cmath>
#include <set>

#include "tests/sim/bodies/sfem/pressed_pad.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/sim/report/plausibility.hpp"

namespace turgor {
namespace {

using test::body_scene;
using test::run_world;
using test::sfem_world;
using test::shown_now;

/// Largest force on the tool [N].
double largest_force(const World& world) {
  double largest = 0;
  for (const ForceSample& s : world.tools[0].samples) largest = std::max(largest, norm(s.force));
  return largest;
}

// Ticks are milliseconds at any frame rate.
TEST(TouchSfem, TicksAreMilliseconds) {
  const auto folder = test::fresh_folder();
  for (const char* rate : {"60", "77", "1000"}) {
    const World world = run_world(
        Exec(1), body_scene(folder, "", {std::string("world.frame_rate=") + rate, "world.duration=0.1"}));
    const auto& samples = world.tools[0].samples;
    ASSERT_GE(samples.size(), 98u) << rate;
    ASSERT_LE(samples.size(), 107u) << rate;
    for (std::size_t i = 0; i < samples.size(); i++)
      EXPECT_NEAR(samples[i].time, 1e-3 * double(i + 1), 1e-12);
  }
}

// The force starts at the surface, grows with depth and vanishes above it.
TEST(TouchSfem, ForceGrowsWithDepth) {
  const World world = run_world(Exec(1), body_scene(test::fresh_folder()));
  const auto& samples = world.tools[0].samples;
  double before = 0, largest = 0;
  for (const ForceSample& s : samples) {
    if (s.depth == 0) {
      EXPECT_LT(norm(s.force), 1e-3) << s.time;
    }
    if (s.time < 0.1) {
      EXPECT_GE(s.force.z, before - 1e-6) << s.time;
      before = s.force.z;
    }
    largest = std::max(largest, s.depth);
  }
  EXPECT_NEAR(largest, 0.003, 1e-4);
  // Hertz predicts 0.101 N for a ball of 6 mm pressed by 3 mm; the mesh is coarse, with a patch of 3.75 mm.
  EXPECT_NEAR(before, 0.1, 0.03);
  EXPECT_GT(world.sfem_bodies[0].rebuilds.size(), 1u) << "the patch follows";
}

// The world has the same bits on 1, 2 and 8 threads.
TEST(TouchSfem, EqualBitsOnAnyThreads) {
  const auto folder = test::fresh_folder();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8})
    hashes.insert(state_hash(run_world(Exec(threads), body_scene(folder, "", {"body.pad.cache=false"}))));
  EXPECT_EQ(hashes.size(), 1u);
}

// Columns computed on demand yield the forces of the full matrix.
TEST(TouchSfem, ColumnsOnDemandMatchDense) {
  const auto folder = test::fresh_folder();
  const World dense = run_world(Exec(1), body_scene(folder, "", {"body.pad.cache=false"}));
  const World demand = run_world(Exec(1), body_scene(folder, "", {"body.pad.memory=0.004"}));
  ASSERT_TRUE(demand.sfem_bodies[0].facts.on_demand);
  EXPECT_NE(demand.sfem_bodies[0].facts.notes[0].find("their columns are computed on demand at the tools"),
            std::string::npos);
  const auto &a = dense.tools[0].samples, &b = demand.tools[0].samples;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); i++)
    EXPECT_NEAR(norm(a[i].force - b[i].force), 0, 1e-4 * largest_force(dense)) << a[i].time;
}

/// Force at the end of the press, when the tool has just stopped [N].
double pressed_force(const World& world) { return norm(world.tools[0].samples[99].force); }

// Viscous tissue resists a fast press and then relaxes.
TEST(TouchSfem, ViscousTissueRelaxes) {
  const auto folder = test::fresh_folder();
  const World elastic = run_world(Exec(1), body_scene(folder, "", {"world.duration=0.15"}));
  const World viscous = run_world(
      Exec(1), body_scene(folder, "viscosity = { ratio = 1, time = 0.05 }\n", {"world.duration=0.15"}));
  EXPECT_GT(pressed_force(viscous), 1.2 * pressed_force(elastic));
  EXPECT_LT(pressed_force(viscous), 2 * pressed_force(elastic));
  EXPECT_LT(norm(viscous.tools[0].samples.back().force), 0.9 * pressed_force(viscous));
  // The displayed surface lies on the patch: the coarse solution has the viscous history, too.
  const BodySnapshot surface = shown_now(Exec(1), viscous);
  double lowest = 0;
  for (const Vec3 u : surface.displacement) lowest = std::min(lowest, double(u.z));
  EXPECT_NEAR(lowest, -0.003, 3e-4);
}

// Corotation changes the force of a small press only slightly.
TEST(TouchSfem, RotationsChangeSmallPressLittle) {
  const auto folder = test::fresh_folder();
  const World plain = run_world(Exec(1), body_scene(folder, "", {"world.duration=0.15"}));
  const World turned = run_world(Exec(1), body_scene(folder, "rotations = true\n", {"world.duration=0.15"}));
  ASSERT_TRUE(turned.sfem_bodies[0].turning);
  EXPECT_EQ(turned.sfem_bodies[0].turning->frames, 9);
  EXPECT_NE(pressed_force(turned), pressed_force(plain));
  EXPECT_NEAR(pressed_force(turned), pressed_force(plain), 0.25 * pressed_force(plain));
}

// Held tissue is pulled with the tool until its release.
TEST(TouchSfem, HeldTissueIsPulled) {
  const auto folder = test::fresh_folder();
  std::string text = test::sfem_scene_text("cache = false\n");
  const std::size_t press = text.find("press = {"), end = text.find('\n', press);
  text.replace(
      press, end - press,
      "path = [[0, 0.03, 0.03, 0.037], [0.1, 0.03, 0.03, 0.034, 1], [0.3, 0.03, 0.03, 0.039, 1], [0.4, "
      "0.03, 0.03, 0.05, 0], [0.5, 0.03, 0.03, 0.05, 0]]");
  const Result<Scene> scene = parse_scene(text, folder / "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const World world = run_world(Exec(1), *scene);
  const auto& samples = world.tools[0].samples;
  EXPECT_GT(samples[99].force.z, 0.01) << "pressed";
  EXPECT_LT(samples[299].force.z, -0.01) << "pulled";
  EXPECT_LT(norm(samples.back().force), 1e-3) << "released";
}

// A tool wider than the body presses it, with a warning. One that is ten times as wide is refused.
TEST(TouchSfem, ToolWiderThanBodyIsWarnedOf) {
  const auto folder = test::fresh_folder();
  World world = sfem_world(Exec(2), body_scene(folder, "", {"tool.finger.shape.sphere=0.05"}));
  for (int frame = 0; frame < 12; frame++) ASSERT_TRUE(step(Exec(2), world));
  EXPECT_GT(norm(world.tools[0].samples.back().force), 0.1) << "N";
  WorldSnapshot snapshot;
  show(Exec(2), world, snapshot);
  ASSERT_EQ(odd_sizes(snapshot).size(), 1u);
  EXPECT_NE(odd_sizes(snapshot)[0].find("finger: its contacting end has a size of "), std::string::npos);
  const Result<World> wide = load_world(Exec(1), body_scene(folder, "", {"tool.finger.shape.sphere=0.4"}));
  ASSERT_FALSE(wide);
  EXPECT_NE(wide.error().message.find("tool.finger: the tool is 0.8 m wide, the body pad 0.06 m"),
            std::string::npos)
      << wide.error().message;
}

// Nearly incompressible averaged tetrahedra yield a plausible force or an error, never a crash.
TEST(TouchSfem, NearlyIncompressibleNeverCrashes) {
  const auto folder = test::fresh_folder();
  const SolidMesh tets = tetrahedralize(hex_block({0.06, 0.06, 0.03}, {8, 8, 4}));
  ASSERT_TRUE(write_msh(folder / "pad.msh", tets));
  for (const char* poisson : {"0.499", "0.49995", "0.4999999", "0.49999999999"}) {
    std::string text = test::sfem_scene_text("formulation = \"averaged\"\ncache = false\n");
    const std::size_t block = text.find("block = {"), end = text.find('\n', block);
    text.replace(block, end - block, "mesh = \"pad.msh\"");
    text.replace(text.find("poisson = 0.4"), 13, std::string("poisson = ") + poisson);
    const Result<Scene> scene = parse_scene(text, folder / "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    Result<World> world = load_world(Exec(1), *scene);
    if (!world) {
      EXPECT_NE(world.error().message.find("lost to rounding"), std::string::npos) << world.error().message;
      continue;
    }
    touch_body(Exec(1), world->sfem_bodies[0], world->tools, 0, 0.1);
    const double force = norm(world->sfem_bodies[0].now.forces[0].force);
    EXPECT_TRUE(force > 0.05 && force < 1) << poisson << ": " << force;
  }
}

}  // namespace
}  // namespace turgor
