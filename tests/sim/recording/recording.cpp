#include "turgor/sim/recording/recording.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/renamed_datasets.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/scene/scene_cells.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// Runs the block and records it; returns the world at the end.
World record_block(const fs::path& folder, const Scene& scene) {
  const Exec exec(1);
  World world = test::block_world(exec, scene);
  Result<RecordingWriter> writer = RecordingWriter::create(folder / "r.h5", scene, world);
  EXPECT_TRUE(writer) << writer.error().message;
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  EXPECT_TRUE(writer->add_snapshot(world, snapshot));
  for (int frame = 0; frame < 10; frame++) EXPECT_TRUE(step(exec, world));
  show(exec, world, snapshot);
  EXPECT_TRUE(writer->add_snapshot(world, snapshot));
  EXPECT_TRUE(writer->finish(world, snapshot, make_pressed(world), "{\"a\": 1}"));
  return world;
}

// Positions, cuts and blade paths are restored bit for bit.
TEST(Recording, RestoresLatticeBits) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  const World world = record_block(folder, scene);
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->snapshot_count(), 2);
  EXPECT_EQ(recording->report(), "{\"a\": 1}");
  const Result<Scene> again = recording->scene({});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->text, scene.text);

  World drawn = test::block_world(Exec(1), *again);
  ASSERT_TRUE(recording->check_world(drawn));
  WorldSnapshot snapshot;
  ASSERT_TRUE(recording->restore(Exec(1), 1, drawn, snapshot));
  const lattice::State &a = world.lattice_bodies[0].state, &b = drawn.lattice_bodies[0].state;
  EXPECT_EQ(drawn.frame, 10);
  EXPECT_EQ(a.motion.u.x, b.motion.u.x);
  EXPECT_EQ(a.motion.u.y, b.motion.u.y);
  EXPECT_EQ(a.motion.u.z, b.motion.u.z);
  EXPECT_EQ(a.cuts.cut, b.cuts.cut);
  EXPECT_EQ(a.cuts.removed, b.cuts.removed);
  EXPECT_EQ(a.cuts.skin_cut, b.cuts.skin_cut);
  EXPECT_EQ(a.cuts.row_cut, b.cuts.row_cut);
  ASSERT_EQ(a.cuts.edges.size(), b.cuts.edges.size());
  EXPECT_GT(a.cuts.edges.size(), 0u);
  const double gape =
      lattice::measure_wound(world.lattice_bodies[0].model, a, *world.cuts[0].path, 0).gape_max;
  EXPECT_EQ(lattice::measure_wound(drawn.lattice_bodies[0].model, b, *drawn.cuts[0].path, 0).gape_max, gape);
  ASSERT_TRUE(recording->restore(Exec(1), 0, drawn, snapshot));
  EXPECT_TRUE(drawn.lattice_bodies[0].state->cuts.edges.empty());
  EXPECT_FALSE(drawn.cuts[0].path);
}

// A replay draws the walls of a wound in the colors of their layers, as the run did, and none before the cut.
TEST(Recording, ReplayDrawsColorsOfLayers) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(
      folder,
      {"body.block.tissue.partial_cells=false",
       "body.block.layers=[{ name = \"skin\", thickness = 0.004, young = 1e5, color = [230, 180, 150] }, "
       "{ name = \"fat\", young = 4e3, color = [240, 214, 120] }]"});
  const World world = record_block(folder, scene);
  WorldSnapshot run, replay;
  show(Exec(1), world, run);
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  const Result<Scene> again = recording->scene({});
  ASSERT_TRUE(again) << again.error().message;
  World drawn = test::block_world(Exec(1), *again);
  ASSERT_TRUE(recording->restore(Exec(1), 1, drawn, replay));
  const WallLayers &a = run.bodies[0].wall_layers, &b = replay.bodies[0].wall_layers;
  ASSERT_FALSE(a.triangles.empty());
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.corner, b.corner);
  EXPECT_EQ(a.layer, b.layer);
  EXPECT_EQ(b.looks.at(1).color, (Rgb{240, 214, 120}));
  ASSERT_TRUE(recording->restore(Exec(1), 0, drawn, replay));
  EXPECT_TRUE(replay.bodies[0].wall_layers.triangles.empty());
}

// Removed regions are restored.
TEST(Recording, RestoresRemovedRegions) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder, {"incision.cut.width=0.02"});
  const World world = record_block(folder, scene);
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  World drawn = test::block_world(Exec(1), scene);
  WorldSnapshot snapshot;
  const Status restored = recording->restore(Exec(1), 1, drawn, snapshot);
  ASSERT_TRUE(restored) << restored.error().message;
  const lattice::State &a = world.lattice_bodies[0].state, &b = drawn.lattice_bodies[0].state;
  EXPECT_GT(std::count(a.cuts.removed.begin(), a.cuts.removed.end(), 1), 0);
  EXPECT_EQ(a.cuts.removed, b.cuts.removed);
  EXPECT_EQ(a.cuts.cut, b.cuts.cut);
}

// A recording does not accept another CT.
TEST(Recording, RejectsOtherCt) {
  const fs::path folder = test::fresh_folder();
  record_block(folder, test::block_scene(folder));
  CtVolume other = test::block_ct();
  other.at(20, 10, 20) = 7;
  ASSERT_TRUE(write_ct(folder / "other.nii", other));
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording);
  const Result<Scene> scene = recording->scene({"body.block.ct=" + (folder / "other.nii").string()});
  ASSERT_TRUE(scene) << scene.error().message;
  const Status status = recording->check_world(test::block_world(Exec(1), *scene));
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("body.block was recorded on another CT: expected content "),
            std::string::npos)
      << status.error().message;
}

// A replay accepts changes of output keys, of wet surfaces and of file names only.
TEST(Recording, ReplayAcceptsOutputChangesOnly) {
  const fs::path folder = test::fresh_folder();
  record_block(folder, test::block_scene(folder));
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording);
  EXPECT_TRUE(recording->scene({"output.color=stretch"}));
  const Result<Scene> wet = recording->scene({"body.block.wet=true"});
  ASSERT_TRUE(wet) << wet.error().message;
  EXPECT_TRUE(wet->look.wet.at("block"));
  EXPECT_EQ(recording->scene({"body.block.block=4"}).error().message,
            "--set body.block.block: a replay may only change output.*, body.*.wet and the locations of a "
            "body's files");
}

// Missing, foreign, old and unfinished files are refused with a message.
TEST(Recording, RejectsForeignFiles) {
  const fs::path folder = test::fresh_folder();
  const std::string path = (folder / "r.h5").string();
  const auto error = [&] { return Recording::open(path).error().message; };
  EXPECT_EQ(error(), path + ": expected an HDF5 file, found nothing");
  ASSERT_TRUE(write_file(path, "not at all"));
  EXPECT_EQ(error(), path + ": expected an HDF5 file, found something else");
  {
    Result<Hdf5File> foreign = Hdf5File::create(path);
    ASSERT_TRUE(foreign);
    ASSERT_TRUE(foreign->write_text("/title", "weather of 1987"));
  }
  EXPECT_EQ(error(), path + ": expected a recording of turgor run, found another HDF5 file");
  {
    Result<Hdf5File> old = Hdf5File::create(path);
    ASSERT_TRUE(old);
    ASSERT_TRUE(old->write_text("/format", "turgor recording 0"));
  }
  EXPECT_EQ(error(),
            path +
                ": expected \"turgor recording 7\", found \"turgor recording 0\", of another version of "
                "turgor");
  {
    Result<Hdf5File> half = Hdf5File::create(path);
    ASSERT_TRUE(half);
    ASSERT_TRUE(half->write_text("/format", "turgor recording 7"));
  }
  EXPECT_EQ(error(), path + ": the recording is unfinished");
}

// Damaged files are errors and never crash.
TEST(Recording, DamagedFilesNeverCrash) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  record_block(folder, scene);
  const std::string whole = read_file(folder / "r.h5").value();
  World world = test::block_world(Exec(1), scene);
  const auto read_all = [&] {
    const Result<Recording> recording = Recording::open(folder / "r.h5");
    if (!recording) return false;
    const Result<Scene> again = recording->scene({});
    if (!again || !recording->check_world(world)) return false;
    WorldSnapshot snapshot;
    for (int s = 0; s < std::min(recording->snapshot_count(), 4); s++)
      if (!recording->restore(Exec(1), s, world, snapshot)) return false;
    return true;
  };
  EXPECT_TRUE(read_all());
  int errors = 0;
  for (int n = 1; n < 20; n++) {  // truncated
    ASSERT_TRUE(write_file(folder / "r.h5", whole.substr(0, whole.size() * std::size_t(n) / 20)));
    errors += !read_all();
  }
  EXPECT_EQ(errors, 19);
  for (int n = 0; n < 200; n++) {  // a changed byte every 2 kB, at other offsets each time
    std::string damaged = whole;
    for (std::size_t i = std::size_t(n) * 37 % 2048; i < damaged.size(); i += 2048)
      damaged[i] = char(damaged[i] ^ 0x55);
    ASSERT_TRUE(write_file(folder / "r.h5", damaged));
    errors += !read_all();
  }
  EXPECT_GE(errors, 19 + 190);
}

// A blade path with a vector that is no unit vector, or with a number that is not finite, is refused by name.
TEST(Recording, RefusesDamagedBladePath) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  const World recorded = record_block(folder, scene);
  const std::string name = recorded.cuts[0].blade.name;
  const auto error_with = [&](const std::string& dataset, double value) -> std::string {
    const fs::path file = folder / "damaged.h5";
    test::write_with_number(folder / "r.h5", file, dataset, 1, value);
    const Result<Recording> recording = Recording::open(file);
    if (!recording) return "not opened: " + recording.error().message;
    World world = test::block_world(Exec(1), scene);
    WorldSnapshot snapshot;
    const Status restored = recording->restore(Exec(1), 1, world, snapshot);
    return restored ? "" : restored.error().message;
  };
  const Result<Hdf5File> file = Hdf5File::open(folder / "r.h5");
  ASSERT_TRUE(file);
  std::string group;
  for (const std::string& path : file->datasets())
    if (path.ends_with("/cuts/" + name + "/into")) group = path.substr(0, path.rfind('/'));
  ASSERT_FALSE(group.empty());
  EXPECT_EQ(error_with(group + "/progress", 0.01), "");
  for (const double value : {2.0, 0.5, 1e300, std::nan("")}) {
    const std::string error = error_with(group + "/into", value);
    EXPECT_NE(error.find("damaged.h5"), std::string::npos) << error;
    EXPECT_NE(error.find(group + "/into: row 1: expected a unit vector"), std::string::npos) << error;
  }
  const std::string error = error_with(group + "/path", std::nan(""));
  EXPECT_NE(error.find(group + "/path: row 1: expected finite numbers"), std::string::npos) << error;
}

// A replay has the cells of the recorded body, whatever the default of scenes is. Older recordings have those
// that their scene chooses, or whole ones.
TEST(Recording, ReplayHasRecordedCells) {
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
TEST(Recording, OlderRecordingsHaveWholeCells) {
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
TEST(Recording, RefusesDamagedCells) {
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
TEST(Recording, ReadsOldDatasetNames) {
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
TEST(Recording, ReadsOldDatasetNamesOfCloth) {
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

/// Message of restoring a snapshot whose surface was damaged before it was written.
template <class Damage>
std::string message_of_damaged(const fs::path& file, const Damage& damage) {
  const Scene scene = *parse_scene(
      "[body.pad]\nmodel = \"sfem\"\ncache = false\nblock = { size = [0.04, 0.04, 0.02], count = [2, 2, 1] "
      "}\n",
      file.parent_path() / "pad.toml");
  World world = *load_world(Exec(1), scene);
  WorldSnapshot snapshot;
  show(Exec(1), world, snapshot);
  damage(body_snapshot(snapshot, {BodyKind::kSfem, 0}));
  {
    Result<RecordingWriter> writer = RecordingWriter::create(file, scene, world);
    EXPECT_TRUE(writer) << writer.error().message;
    EXPECT_TRUE(writer->add_snapshot(world, snapshot));
    EXPECT_TRUE(writer->finish(world, snapshot, make_pressed(world), "{}"));
  }
  const Result<Recording> recording = Recording::open(file);
  EXPECT_TRUE(recording) << recording.error().message;
  const Status restored = recording->restore(Exec(1), 0, world, snapshot);
  EXPECT_FALSE(restored);
  return restored ? "" : restored.error().message;
}

// A damaged surface is named with its file.
TEST(Recording, DamagedSurfaceIsNamedWithFile) {
  const fs::path folder = test::fresh_folder();
  const auto no_number = [](BodySnapshot& body) {
    body.displacement[3].y = std::numeric_limits<float>::quiet_NaN();
  };
  const auto walls_beyond = [](BodySnapshot& body) { body.wall_begin = body.triangles.size() + 1; };
  const auto caps_beyond = [](BodySnapshot& body) { body.cap_count = body.wall_begin + 1; };
  for (const std::string& message :
       {message_of_damaged(folder / "r.h5", no_number), message_of_damaged(folder / "r.h5", walls_beyond),
        message_of_damaged(folder / "r.h5", caps_beyond)}) {
    EXPECT_EQ(message.find((folder / "r.h5").string() + ": /snapshots/"), 0u) << message;
    EXPECT_NE(message.find("pad/: the surface is damaged"), std::string::npos) << message;
  }
}

// The corpus of the fuzz tests, a recording of format 6, is read.
TEST(Recording, FuzzCorpusReplays) {
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
