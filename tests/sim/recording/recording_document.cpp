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
[body.weight]
model = "rigid"
shape = { sphere = 0.01 }
at = [0, 0.2, 0.011]
mass = 0.02
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

// The datasets of a rigid body give its drawn surface by the formula of the document, c + R(q) (r - c0).
TEST(RecordingDocument, RigidPoseGivesSurface) {
  const fs::path folder = test::fresh_folder();
  const Result<Scene> scene = parse_scene(
      "[world]\ngravity = [0, 0, -9.81]\n[body.brick]\nmodel = \"rigid\"\n"
      "shape = { box = [0.04, 0.06, 0.1] }\nat = [0.1, 0.2, 0.3]\nturn = [20, 0, 30]\nmass = 0.02\n"
      "velocity = [1, -2, 0.5]\nspin = [7, 11, -5]\n",
      folder / "brick.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  World world = *load_world(Exec(1), *scene);
  for (int frame = 0; frame < 9; frame++) ASSERT_TRUE(step(Exec(1), world));
  const WorldSnapshot snapshot = test::record_snapshot(Exec(1), folder / "r.h5", *scene, world);
  const Result<Hdf5File> file = Hdf5File::open(folder / "r.h5");
  ASSERT_TRUE(file) << file.error().message;
  const auto read = [&file](const char* name, std::size_t count) {
    return file->read<double>(std::string("/snapshots/00000/bodies/brick/") + name, count).value();
  };
  const std::vector<double> c = read("center", 3), c0 = read("rest_center", 3), q = read("rotation", 4);
  const std::vector<Vec3>& drawn = snapshot.bodies[0].x;
  const std::vector<float> rest =
      file->read<float>("/snapshots/00000/bodies/brick/rest", 3 * drawn.size()).value();
  const Vec3d axis{q[1], q[2], q[3]};
  EXPECT_GT(norm(axis), 0.3) << "it has turned";
  for (std::size_t v = 0; v < drawn.size(); v++) {
    const Vec3d r{rest[3 * v] - c0[0], rest[3 * v + 1] - c0[1], rest[3 * v + 2] - c0[2]};
    // R(q) r = r + 2 w (u x r) + 2 u x (u x r)  [any text on quaternions, q = w + u]
    const Vec3d turned = r + cross(axis, r) * (2 * q[0]) + cross(axis, cross(axis, r)) * 2;
    EXPECT_LT(norm(Vec3d(drawn[v]) - (Vec3d{c[0], c[1], c[2]} + turned)), 1e-6) << v;
  }
}

}  // namespace
}  // namespace turgor
