// docs/recording.md compared with a recording of every model.
#include <map>
#include <regex>
#include <sstream>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/files/hdf5_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOthers = R"(
[suture.row]
wound = "cut"
bite = 0.012
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [4, 4, 2] }
fixed = "bottom"
cache = false
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.3 }
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 1], side = [0.1, 0, 0], up = [0, 0.1, 0], columns = 4, rows = 4 }
[tool.a]
body = "pad"
shape = { sphere = 0.006 }
press = { at_fraction = [0.5, 0.5, 1] }
[tool.b]
body = "liver"
shape = { sphere = 0.006 }
press = { at_fraction = [0.5, 0.5, 1] }
)";

/// Datasets of the document's tables and their units.
std::map<std::string, std::string> documented() {
  std::map<std::string, std::string> found;
  std::istringstream lines(read_file(fs::path(TURGOR_SOURCE_DIR) / "docs" / "recording.md").value());
  const std::regex row(R"(\| `(/[^`]+)` \| [^|]* \| ?([^|]*?) \|.*)");
  std::smatch cells;
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, cells, row)) found[cells[1]] = cells[2];
  return found;
}

/// Replaces the names in a path: "/bodies/torso/cut" becomes "/bodies/NAME/cut" as in the document.
std::string general(std::string name) {
  name = std::regex_replace(name, std::regex("/(bodies|cuts|sutures|surfaces|deepest|tools)/[^/]+/"),
                            "/$1/NAME/");
  return std::regex_replace(name, std::regex("/[0-9]{5}/"), "/NNNNN/");
}

// The document lists exactly the datasets of a recording, with their units.
TEST(RecordingDocument, ListsExactlyAllDatasets) {
  const fs::path folder = test::fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const Result<Scene> scene =
      parse_scene(test::block_scene_text("block.nii") + kOthers, folder / "all.toml", {});
  ASSERT_TRUE(scene) << scene.error().message;
  World world = test::block_world(Exec(2), *scene);
  // as in solid tissue after a cut
  world.lattice_bodies[0].state.change().motion.virtual_u.push_back({});
  world.lattice_bodies[0].state.change().cuts.samples.push_back({});
  (void)test::record_snapshot(Exec(2), folder / "r.h5", *scene, world);
  const Result<Hdf5File> file = Hdf5File::open(folder / "r.h5");
  ASSERT_TRUE(file) << file.error().message;
  std::map<std::string, std::string> held;
  for (const std::string& name : file->datasets()) held[general(name)] = file->read_attribute(name, "unit");
  EXPECT_EQ(held, documented());
}

}  // namespace
}  // namespace turgor
