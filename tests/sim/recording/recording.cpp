#include "turgor/sim/recording/recording.hpp"

#include <algorithm>

#include "tests/sim/recording/record_block.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::record_block;

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

}  // namespace
}  // namespace turgor
