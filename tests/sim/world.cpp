#include "turgor/sim/world.hpp"

#include "tests/sim/block_scene.hpp"

namespace turgor {
namespace {

using test::block_scene;
using test::block_world;
using test::fresh_folder;

// The blade moves with time and cuts progressively.
TEST(World, BladeCutsProgressively) {
  const Exec exec(1);
  World world = block_world(exec, block_scene(fresh_folder()));
  std::vector<double> done;
  std::vector<int> edges;
  for (int frame = 0; frame < 10; frame++) {
    const Result<FrameReport> report = step(exec, world);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->finite);
    done.push_back(world.cuts[0].done);
    edges.push_back(world.cuts[0].edges);
  }
  // 50 frames a second; the blade starts at 0.05 s and takes 0.05 s.
  const std::vector<double> expected = {0, 0, 0.2, 0.6, 1, 1, 1, 1, 1, 1};
  for (std::size_t f = 0; f < expected.size(); f++) EXPECT_NEAR(done[f], expected[f], 1e-6) << "frame " << f;
  EXPECT_EQ(edges[1], 0);
  EXPECT_GT(edges[2], 0);
  EXPECT_GT(edges[3], edges[2]);
  EXPECT_GT(edges[4], edges[3]);
  EXPECT_EQ(edges[9], edges[4]);
}

// A cut opens under the tension of the skin.
TEST(World, TensionOpensCut) {
  const Exec exec(1);
  World world = block_world(exec, block_scene(fresh_folder()));
  for (int frame = 0; frame < 25; frame++) ASSERT_TRUE(step(exec, world));
  const lattice::Wound wound = lattice::measure_wound(world.lattice_bodies[0].model,
                                                      world.lattice_bodies[0].state, *world.cuts[0].path, 0);
  EXPECT_GT(wound.gape_max, 0.001);  // measured: several millimeters
  EXPECT_LT(wound.gape_max, 0.04);
}

// The state has the same bits on 1, 2 and 8 threads.
TEST(World, EqualBitsOnAnyThreads) {
  std::vector<std::uint64_t> hashes;
  const Scene scene = block_scene(fresh_folder());
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    World world = block_world(exec, scene);
    for (int frame = 0; frame < 10; frame++) ASSERT_TRUE(step(exec, world));
    hashes.push_back(lattice::state_hash(world.lattice_bodies[0].model, world.lattice_bodies[0].state));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

// Fractions of the body's box select points on its surface.
TEST(World, FractionsSelectSurface) {
  const Exec exec(1);
  const World world = block_world(exec, block_scene(fresh_folder()));
  const lattice::Model& model = world.lattice_bodies[0].model;
  const Box box = body_box(model);
  lattice::Incision fractions;
  fractions.from = {0.5, 0, 0.25}, fractions.to = {0.5, 0, 0.75};
  const lattice::Incision blade = blade_from_fractions(model, fractions);
  EXPECT_NEAR(blade.from.y, box.low.y, model.anatomy.grid.spacing.y);
  EXPECT_NEAR(blade.from.z, 0.75 * box.low.z + 0.25 * box.high.z, 1e-9);
  EXPECT_NEAR(blade.to.x, 0.5 * (box.low.x + box.high.x), 1e-9);
  EXPECT_TRUE(lattice::lay_blade(model, world.lattice_bodies[0].state, blade));
}

// A spacing in meters is rounded to whole voxels.
TEST(World, SpacingRoundsToWholeVoxels) {
  const std::filesystem::path folder = fresh_folder();
  std::string text = test::block_scene_text("block.nii");
  text.replace(text.find("block = 2"), 9, "spacing = 0.0115");
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const World world = block_world(Exec(1), parse_scene(text, folder / "block.toml").value());
  EXPECT_EQ(world.lattice_bodies[0].model.params.block, (Int3{3, 3, 3}));
}

// Errors are found before the first frame and name their location.
TEST(World, ErrorsAreFoundOnLoad) {
  const Exec exec(1);
  const std::filesystem::path folder = fresh_folder();
  const auto error = [&](const std::vector<std::string>& overrides) {
    const Result<World> world = load_world(exec, block_scene(folder, overrides));
    return world ? "no error" : world.error().message;
  };
  EXPECT_NE(error({"incision.cut.from=[1,1,1]", "incision.cut.to=[1,1,2]"})
                .find("block.toml:9:1: incision.cut: incision 'cut': no skin"),
            std::string::npos)
      << error({"incision.cut.from=[1,1,1]", "incision.cut.to=[1,1,2]"});
  EXPECT_NE(error({"body.block.ct=/nowhere.nii"}).find("block.toml:4:1: body.block: /nowhere.nii"),
            std::string::npos)
      << error({"body.block.ct=/nowhere.nii"});
}

}  // namespace
}  // namespace turgor
