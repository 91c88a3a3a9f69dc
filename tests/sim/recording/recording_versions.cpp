// Recordings of earlier versions, and the kind of cells that recordings store.
#include "tests/sim/block_scene.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/renamed_datasets.hpp"
#include "turgor/sim/scene/scene_cells.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

// A replay has the cells of the recorded body, whatever the default of scenes is. Older recordings have those
// that their scene chooses, or whole ones.
TEST(RecordingVersions, ReplayHasRecordedCells) {
  const fs::path folder = test::fresh_folder();
  const std::string key = "body.block.tissue.partial_cells";
  for (const bool partial : {true, false}) {
    // a body with the other cells than its text says
    Scene scene = test::block_scene(folder, {key + (partial ? "=false" : "=true")});
    scene.lattice_bodies[0].params.tissue.partial_cells = partial;
    World world = test::block_world(Exec(1), scene);
    for (int frame = 0; frame < 3; frame++) ASSERT_TRUE(step(Exec(1), world));
    (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
    const Result<Scene> again = Recording::open(folder / "r.h5")->scene({});
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->lattice_bodies[0].params.tissue.partial_cells, partial);
    World drawn = test::block_world(Exec(1), *again);
    (void)test::restore_snapshot(Exec(1), folder / "r.h5", drawn);
    EXPECT_EQ(drawn.lattice_bodies[0].state->motion.u.y, world.lattice_bodies[0].state->motion.u.y);
    // without the dataset
    ASSERT_EQ(test::write_with_names(folder / "r.h5", folder / "old.h5", {{"partial_cells", "unknown"}},
                                     "turgor recording 7"),
              1);
    EXPECT_NE(Recording::open(folder / "old.h5")->scene({})->lattice_bodies[0].params.tissue.partial_cells,
              partial);
  }
}

// Recordings that do not store their cells have whole ones, as the default was, and are restored bit for bit.
TEST(RecordingVersions, OlderRecordingsHaveWholeCells) {
  const fs::path folder = test::fresh_folder();
  Scene scene = test::block_scene(folder);
  EXPECT_TRUE(scene.lattice_bodies[0].params.tissue.partial_cells);
  use_whole_cells(scene);
  World world = test::block_world(Exec(1), scene);
  for (int frame = 0; frame < 5; frame++) ASSERT_TRUE(step(Exec(1), world));
  (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
  ASSERT_EQ(test::write_with_names(folder / "r.h5", folder / "old.h5", {{"partial_cells", "unknown"}},
                                   "turgor recording 7"),
            1);
  const Result<Recording> old = Recording::open(folder / "old.h5");
  ASSERT_TRUE(old) << old.error().message;
  const Result<Scene> again = old->scene({});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(cells_text(again->lattice_bodies[0]), "whole, since its recording has them");
  World drawn = test::block_world(Exec(1), *again);
  ASSERT_TRUE(old->check_world(drawn));
  (void)test::restore_snapshot(Exec(1), folder / "old.h5", drawn);
  EXPECT_EQ(drawn.lattice_bodies[0].state->motion.u.y, world.lattice_bodies[0].state->motion.u.y);
}

// A damaged kind of cells is refused by name: a number that means nothing, and partial cells of a stiffening
// law.
TEST(RecordingVersions, RefusesDamagedCells) {
  const fs::path folder = test::fresh_folder();
  const std::string law = "body.block.tissue={ law = \"exponential\", stiffening = 2 }";
  for (const bool stiffens : {false, true}) {
    const Scene scene = test::block_scene(folder, stiffens ? std::vector{law} : std::vector<std::string>{});
    const World world = test::block_world(Exec(1), scene);
    (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
    test::write_with_number(folder / "r.h5", folder / "damaged.h5", "/bodies/block/partial_cells", 0,
                            stiffens ? 1 : 7);
    const Result<Scene> again = Recording::open(folder / "damaged.h5")->scene({});
    ASSERT_FALSE(again);
    EXPECT_NE(again.error().message.find(stiffens ? "partial_cells: expected 0, since"
                                                  : "partial_cells: expected 0 or 1, found 7"),
              std::string::npos)
        << again.error().message;
  }
}

// Recordings with the dataset names of format 6 restore the same state.
TEST(RecordingVersions, ReadsOldDatasetNames) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  World world = test::block_world(Exec(1), scene);
  for (int frame = 0; frame < 10; frame++) ASSERT_TRUE(step(Exec(1), world));
  const lattice::State& state = world.lattice_bodies[0].state;
  (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
  const int renamed = test::write_with_names(
      folder / "r.h5", folder / "old.h5",
      {{"virtual_nodes", "copies"}, {"cut_edge_sub_index", "cut_edge_part"}}, "turgor recording 6");
  EXPECT_EQ(renamed, 2);

  World drawn = test::block_world(Exec(1), scene);
  (void)test::restore_snapshot(Exec(1), folder / "old.h5", drawn);
  const lattice::State& read = drawn.lattice_bodies[0].state;
  ASSERT_EQ(read.motion.virtual_u.size(), state.motion.virtual_u.size());
  ASSERT_GT(read.motion.virtual_u.size(), 0u);
  EXPECT_EQ(read.motion.virtual_u.back().y, state.motion.virtual_u.back().y);
  ASSERT_EQ(read.cuts.edges.size(), state.cuts.edges.size());
  ASSERT_GT(read.cuts.edges.size(), 0u);
  for (std::size_t e = 0; e < read.cuts.edges.size(); e++)
    EXPECT_EQ(read.cuts.edges[e].sub_index, state.cuts.edges[e].sub_index);
}

// Recordings of cloth with the dataset names of format 6 restore the same state.
TEST(RecordingVersions, ReadsOldDatasetNamesOfCloth) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = *parse_scene(
      "[world]\ngravity = [0, 0, -9.81]\n[body.sheet]\nmodel = \"cloth\"\n"
      "sheet = { side = [0.1, 0, 0], up = [0, 0.1, 0], columns = 4, rows = 4 }\n",
      folder / "cloth.toml");
  World world = *load_world(Exec(1), scene);
  for (int frame = 0; frame < 3; frame++) ASSERT_TRUE(step(Exec(1), world));
  (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
  ASSERT_EQ(test::write_with_names(folder / "r.h5", folder / "old.h5", {{"positions", "places"}},
                                   "turgor recording 6"),
            1);
  World drawn = *load_world(Exec(1), scene);
  (void)test::restore_snapshot(Exec(1), folder / "old.h5", drawn);
  EXPECT_EQ(drawn.cloth_bodies[0].state->x.z, world.cloth_bodies[0].state->x.z);
}

// The corpus of the fuzz tests, a recording of format 6, is read.
TEST(RecordingVersions, FuzzCorpusReplays) {
  const std::filesystem::path folder = std::filesystem::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz";
  const Result<Recording> recording = Recording::open(folder / "corpus" / "recording" / "recording.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  const Exec exec(1);
  Result<World> world = load_world(exec, *read_scene(folder / "recorded.toml"), {}, Purpose::kDraw);
  ASSERT_TRUE(world) << world.error().message;
  ASSERT_TRUE(recording->check_world(*world));
  WorldSnapshot snapshot;
  std::vector<Pressed> pressed;
  for (int s = 0; s < recording->snapshot_count(); s++)
    EXPECT_TRUE(recording->restore(exec, s, *world, snapshot));
  EXPECT_TRUE(recording->restore_touch(*world, pressed));
}

}  // namespace
}  // namespace turgor
