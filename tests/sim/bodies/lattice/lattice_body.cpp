#include "turgor/sim/bodies/lattice/lattice_body.hpp"

#include <set>

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/sim/block_scene.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::block_scene;
using test::block_world;
using test::fresh_folder;

/// The block of fat on bone, pressed in its middle from the front, which is at y = −20 mm.
Scene touched_scene(const std::filesystem::path& folder, const std::string& motion,
                    const std::string& more = "") {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text =
      "[world]\nduration = 1\nframe_rate = 50\n"
      "[body.block]\nmodel = \"lattice\"\nct = \"block.nii\"\nblock = 2\nskin = false\n"
      "solver = { sweeps = 20, damping = 8 }\n" +
      more + "[tool.finger]\nbody = \"block\"\nshape = { sphere = 0.014 }\n" + motion;
  Result<Scene> scene = parse_scene(text, folder / "s.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}
const char* kPress = "press = { at_fraction = [0.5, 0, 0.5], depth = 0.006, start = 0.1, duration = 0.3 }\n";

// A press yields one force per frame, which pushes the tool out; the drawn surface lies on the tool.
TEST(LatticeSceneBody, PressPushesToolOut) {
  World world = block_world(Exec(2), touched_scene(fresh_folder(), kPress));
  std::vector<Pressed> all = make_pressed(world);
  for (int frame = 0; frame < 50; frame++) {
    ASSERT_TRUE(step(Exec(2), world));
    update_pressed(Exec(2), world, all);
  }
  const TouchLog& samples = world.tools[0].samples;
  ASSERT_EQ(samples.size(), 50u);
  const auto at = [&](double time) { return samples[std::size_t(std::lround(time * 50)) - 1]; };
  EXPECT_EQ(norm(at(0.1).force), 0) << "before contact";
  EXPECT_LT(at(0.5).force.y, -0.1) << "N: towards the front";
  EXPECT_NEAR(at(0.5).depth, 0.006, 0.0005) << "m";
  EXPECT_GT(at(0.5).contacts, 3);
  EXPECT_EQ(norm(at(0.98).force), 0) << "after the release";
  const Pressed& pressed = pressed_body(all, {BodyKind::kLattice, 0});
  EXPECT_EQ(pressed.body.rest.size(), pressed.body.displacement.size());
  float deepest = 0;
  for (const Vec3 u : pressed.body.displacement) deepest = std::max(deepest, u.y);
  EXPECT_NEAR(deepest, 0.006, 0.001) << "m: the drawn surface lies on the tool";
  EXPECT_NEAR(pressed.force, norm(at(pressed.time).force), 1e-12) << "N";
}

// A grasp pulls the surface out and releases it.
TEST(LatticeSceneBody, GraspPullsSurface) {
  const char* grasp =
      "grasp = { at_fraction = [0.5, 0, 0.5], depth = 0.003, pull = 0.01, duration = 0.2, hold = 0.1 }\n";
  World world = block_world(Exec(2), touched_scene(fresh_folder(), grasp));
  double pulled = 0;
  for (int frame = 0; frame < 50; frame++) {
    ASSERT_TRUE(step(Exec(2), world));
    pulled = std::max(pulled, world.tools[0].samples.back().force.y);
  }
  EXPECT_GT(pulled, 0.1) << "N: back into the body";
  EXPECT_EQ(norm(world.tools[0].samples.back().force), 0) << "N: released";
}

// A tool that moves 17 mm in a frame does not pass through the body.
TEST(LatticeSceneBody, FastToolIsSubstepped) {
  const char* fast =
      "path = [[0, 0, -0.06, 0], [0.2, 0, -0.06, 0], [0.24, 0, -0.026, 0], [1, 0, -0.026, 0]]\n";
  World world = block_world(Exec(2), touched_scene(fresh_folder(), fast));
  for (int frame = 0; frame < 30; frame++) ASSERT_TRUE(step(Exec(2), world));  // one of them moves 17 mm
  EXPECT_LT(world.tools[0].samples.back().force.y, -0.1) << "N: pushed out to the front, not through";
  EXPECT_LT(world.lattice_bodies[0].forces[0].largest_penetration, 1e-4) << "m";
}

/// A press, and a cut after 0.3 s.
Scene cut_scene(const std::filesystem::path& folder, const std::string& solver = "") {
  const std::string cut =
      "skin = { tension = 5 }\n[incision.cut]\nbody = \"block\"\nfrom = [0.002, -0.02, -0.03]\n"
      "to = [0.002, -0.02, 0.03]\nstart = 0.3\n";
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.5\nframe_rate = 50\n[body.block]\nmodel = \"lattice\"\nct = "
      "\"block.nii\"\nblock = 2\n" +
          solver + cut + "[tool.finger]\nbody = \"block\"\nshape = { capsule = [0.012, 0.01] }\n" + kPress,
      folder / "s.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

// A press with a cut has the same bits on 1 and 2 threads.
TEST(LatticeSceneBody, EqualBitsOnAnyThreads) {
  const Scene scene = cut_scene(fresh_folder());
  std::set<double> forces;
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2}) {
    World world = block_world(Exec(threads), scene);
    for (int frame = 0; frame < 25; frame++) ASSERT_TRUE(step(Exec(threads), world));
    forces.insert(norm(world.tools[0].samples.back().force));
    hashes.insert(lattice::state_hash(world.lattice_bodies[0].model, world.lattice_bodies[0].state));
    EXPECT_GT(world.cuts[0].edges, 0);
  }
  EXPECT_EQ(forces.size(), 1u);
  EXPECT_EQ(hashes.size(), 1u);
  EXPECT_GT(*forces.begin(), 0.01) << "N";
}

// A lattice on a backend is pressed and cut as on the host. The backend is the host with shuffled order. It
// has whole cells, since contacts at points of partial cells need the host.
TEST(LatticeSceneBody, BackendMatchesHost) {
  const Scene scene = cut_scene(fresh_folder(),
                                "solver = { ordering = \"colors\" }\n"
                                "tissue = { partial_cells = false }\n");
  const auto run = [&](bool on_backend) {
    World world = block_world(Exec(2), scene);
    LatticeBody& body = world.lattice_bodies[0];
    body.model.params.solver.coarse = false;
    if (on_backend) body.state.use_backend(lattice::put_on_host<lattice::SeededRun<1>>(body.model));
    for (int frame = 0; frame < 20; frame++) EXPECT_TRUE(step(Exec(2), world));
    World copy = copy_of(world);
    for (int frame = 0; frame < 5; frame++) EXPECT_TRUE(step(Exec(2), world));
    for (int frame = 0; frame < 5; frame++) EXPECT_TRUE(step(Exec(2), copy));
    EXPECT_EQ(state_hash(copy), state_hash(world)) << "on a backend: " << on_backend;
    EXPECT_GT(world.cuts[0].edges, 0);
    return world;
  };
  const World host = run(false), device = run(true);
  const lattice::State &a = host.lattice_bodies[0].state, &b = device.lattice_bodies[0].state;
  double most = 0, largest = 0;
  for (std::size_t s = 0; s < a.motion.u.x.size(); s++) {
    most = std::max(most, double(norm(a.motion.u[s] - b.motion.u[s])));
    largest = std::max(largest, double(norm(a.motion.u[s])));
  }
  EXPECT_GT(largest, 1e-3) << "m";
  EXPECT_LT(most, 1e-3 * largest) << "m: fused multiply-adds may differ";
  ASSERT_EQ(a.motion.virtual_u.size(), b.motion.virtual_u.size());
  EXPECT_GT(a.motion.virtual_u.size(), 0u);
  const Vec3d force = host.tools[0].samples.back().force;
  EXPECT_GT(norm(force), 0.01) << "N";
  EXPECT_LT(norm(device.tools[0].samples.back().force - force), 1e-3 * norm(force)) << "N";
}

// The error for an empty box of fixed nodes has the bounds of the body.
TEST(LatticeSceneBody, EmptyFixedBoxNamesBodyBounds) {
  const std::filesystem::path folder = test::fresh_folder();
  const Scene scene = block_scene(folder, {"body.block.fixed={ box = [[1, 0, 0], [1.1, 0.1, 0.1]] }"});
  const Result<World> world = load_world(Exec(2), scene);
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().message.find("body.block: fixed: the box from (1, 0, 0) m to (1.1, 0.1, 0.1) m "
                                       "contains no vertex of the body; the body is between ("),
            std::string::npos)
      << world.error().message;
}

// A body of one label is cropped to it and fixed at a side of its box.
TEST(LatticeSceneBody, LabelIsFixedAtSideOfItsBox) {
  Result<Scene> scene = parse_scene(
      "[body.liver]\nmodel = \"lattice\"\nct = { phantom = \"torso\", size = [64, 64, 40], spacing_mm = "
      "[6.3, 6.3, 7.6] }\n"
      "only = \"liver\"\nblock = 1\nskin = false\nfixed = { sides = \"back\", depth = 0.3 }\n",
      "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const World world = block_world(Exec(2), *scene);
  const LatticeBody& body = world.lattice_bodies[0];
  const double voxel = sample_volume(body.ct.grid);
  const auto tissue =
      std::count_if(body.ct.samples.begin(), body.ct.samples.end(), [](auto hu) { return hu > -449; });
  EXPECT_NEAR(double(tissue) * voxel, 1.4e-3, 0.4e-3) << "m³: a liver";
  EXPECT_LT(body.ct.grid.size.x, 50) << "the CT is cropped to the label";
  const Box box = body_box(body.model);
  const Int3 size = body.model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const auto slot = std::size_t(node_slot(body.model.anatomy.lattice, i, j, k));
        if (!lattice::is_body(body.model.anatomy.tissue[slot])) continue;
        const double y = point_at(body.model.anatomy.grid, {double(i), double(j), double(k)}).y;
        const bool behind = y >= box.high.y - 0.3 * (box.high.y - box.low.y) - 1e-9;
        ASSERT_EQ(body.model.anatomy.inverse_mass[slot] == 0, behind) << "y = " << y << " m";
      }
}

// A block in voxels that makes a large, fine lattice of a CT is noted, with the spacing that suits every CT.
TEST(LatticeSceneBody, FineBlockIsNoted) {
  const auto notes = [](const std::string& size) {
    const Result<Scene> scene =
        parse_scene("[body.torso]\nmodel = \"lattice\"\nskin = false\nct = { phantom = \"torso\", " + size +
                        " }\nblock = 1\n",
                    "s.toml");
    EXPECT_TRUE(scene) << scene.error().message;
    World world = block_world(Exec(2), *scene);
    std::string all;
    for (const std::string& note : world.lattice_bodies[0].notes) all += note + "\n";
    return all;
  };
  const std::string fine = notes("size = [112, 84, 72], spacing_mm = [1.2, 1.2, 1.2]");
  EXPECT_NE(fine.find("block = [1, 1, 1] voxels makes a lattice of 1.2 mm"), fine.npos) << fine;
  EXPECT_NE(fine.find("spacing = 0.004"), fine.npos) << fine;
  EXPECT_EQ(notes("size = [56, 42, 36], spacing_mm = [2.4, 2.4, 2.4]").find("spacing = 0.004"), fine.npos);
}

}  // namespace
}  // namespace turgor
