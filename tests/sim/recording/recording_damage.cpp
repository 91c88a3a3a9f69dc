// Damaged recordings are refused by name and never crash.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/refused.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/recording/record_block.hpp"
#include "tests/sim/renamed_datasets.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::record_block;

// Damaged files are errors and never crash.
TEST(RecordingDamage, DamagedFilesNeverCrash) {
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
TEST(RecordingDamage, RefusesDamagedBladePath) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  const World recorded = record_block(folder, scene);
  const std::string name = recorded.cuts[0].blade.name;
  const auto error_with = [&](const std::string& dataset, double value,
                              std::size_t index = 1) -> std::string {
    const fs::path file = folder / "damaged.h5";
    test::write_with_number(folder / "r.h5", file, dataset, index, value);
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
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    const std::string error = error_with(group + "/progress", value, 2);
    EXPECT_NE(error.find(group + "/progress: expected finite numbers"), std::string::npos) << error;
  }
  for (const double value : {2.0, 0.5, 1e300, std::nan("")}) {
    const std::string error = error_with(group + "/into", value);
    EXPECT_NE(error.find("damaged.h5"), std::string::npos) << error;
    EXPECT_NE(error.find(group + "/into: row 1: expected a unit vector"), std::string::npos) << error;
  }
  const std::string error = error_with(group + "/path", std::nan(""));
  EXPECT_NE(error.find(group + "/path: row 1: expected finite numbers"), std::string::npos) << error;
}

// A number of contacts of a tool that is no number is refused by name.
TEST(RecordingDamage, RefusesDamagedContacts) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(
      folder,
      {"tool.tip={ body = 'block', shape = { sphere = 0.005 }, press = { at_fraction = [0.66, 0, 0.5], "
       "depth = 0.003 } }"});
  World world = test::block_world(Exec(1), scene);
  for (int frame = 0; frame < 2; frame++) ASSERT_TRUE(step(Exec(1), world));
  (void)test::record_snapshot(Exec(1), folder / "r.h5", scene, world);
  constexpr std::size_t kRow = 27, kContacts = 10;  // docs/recording.md
  test::write_with_number(folder / "r.h5", folder / "damaged.h5", "/tools/tip/ticks", kRow + kContacts,
                          std::nan(""));
  std::vector<Pressed> pressed;
  EXPECT_TRUE(Recording::open(folder / "r.h5")->restore_touch(world, pressed));
  EXPECT_REFUSED(Recording::open(folder / "damaged.h5")->restore_touch(world, pressed),
                 "damaged.h5: /tools/tip/ticks: row 2: expected a number of contacts, found nan");
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
TEST(RecordingDamage, DamagedSurfaceIsNamedWithFile) {
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

}  // namespace
}  // namespace turgor
