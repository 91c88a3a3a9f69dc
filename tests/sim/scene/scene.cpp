#include "turgor/sim/scene/scene.hpp"

#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

using test::error_of;

const std::string kScene = R"(
[world]
gravity = [0, 9.81, 0]
duration = 1.5
frame_rate = 30

[body.torso]
model = "lattice"
ct = "ct/patient.nii.gz"
labels = "/seg.nii.gz"
block = [2, 2, 1]
fixed = ["bone", "ends"]
tissue = { law = "springs", fat = 4e3, muscle = 1.5e4, volume = 2, labels = { liver = 4e3, 77 = 5e3 } }
skin = { law = "fiber", tension = [60, 30], stiffness = 250, shear = 90, amplification = 1, direction = [0, 0, 1] }
solver = { method = "vbd", sweeps = 7, damping = 2 }

[incision.first]
body = "torso"
from = [0.01, -0.1, 0.02]
to = [0.01, -0.1, 0.12]
depth = 0.012
start = 0.25
duration = 0.5

[incision.second]
body = "torso"
from_fraction = [0.2, 0.0, 0.5]
to_fraction = [0.4, 0.0, 0.5]
width = 0.01

[output]
snapshots = { every = 0.25, size = [320, 240] }
color = "stretch"
volume_rendering = false
window = "bone"
deformed_ct = "deformed.nrrd"
deformed_size = [64, 64, 32]
obj = false
)";

/// The smallest scene, with lines added to its body and at its end.
std::string small_scene(const std::string& body = "", const std::string& rest = "") {
  return "[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n" + body + "\n" + rest;
}

lattice::TissueLaw law_of(const std::string& body) {
  const Result<Scene> scene = parse_scene(small_scene(body), "s.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  return scene->lattice_bodies[0].params.tissue.law;
}

// Tissue is solid unless the scene selects springs or PBD, which supports springs only.
TEST(Scene, TissueLawDefaultsToSolid) {
  EXPECT_EQ(law_of(""), lattice::TissueLaw::kSolid);
  EXPECT_EQ(law_of("tissue = { young = 5e3, poisson = 0.3 }"), lattice::TissueLaw::kSolid);
  EXPECT_EQ(law_of("tissue = { law = \"springs\" }"), lattice::TissueLaw::kSprings);
  EXPECT_EQ(law_of("solver = { method = \"pbd\" }\nskin = { law = \"area\" }"), lattice::TissueLaw::kSprings);
}

// Every key reaches its field.
TEST(Scene, KeysReachFields) {
  const Result<Scene> parsed = parse_scene(kScene, "/scenes/s.toml");
  ASSERT_TRUE(parsed) << parsed.error().message;
  const Scene& scene = *parsed;
  EXPECT_EQ(scene.gravity, (Vec3d{0, 9.81, 0}));
  EXPECT_EQ(scene.duration, 1.5);
  EXPECT_EQ(frame_count(scene), 45);
  ASSERT_EQ(scene.lattice_bodies.size(), 1u);
  const LatticeScene& torso = scene.lattice_bodies[0];
  EXPECT_EQ(torso.name, "torso");
  EXPECT_EQ(torso.ct.file, "/scenes/ct/patient.nii.gz");
  EXPECT_EQ(torso.labels, "/seg.nii.gz");
  EXPECT_EQ(torso.params.block, (Int3{2, 2, 1}));
  EXPECT_TRUE(torso.params.fix_bone);
  EXPECT_TRUE(torso.params.fix_ends);
  EXPECT_EQ(torso.params.tissue.fat, 4e3);
  EXPECT_EQ(torso.params.tissue.volume, 2);
  EXPECT_EQ(torso.params.tissue.law, lattice::TissueLaw::kSprings);
  EXPECT_EQ(torso.params.tissue.young_of_label, (std::map<int, double>{{5, 4e3}, {77, 5e3}}));
  EXPECT_EQ(torso.params.skin.tension_along, 60);
  EXPECT_EQ(torso.params.skin.tension_across, 30);
  EXPECT_EQ(torso.params.skin.stiffness, 250);
  EXPECT_EQ(torso.params.skin.direction, (Vec3d{0, 0, 1}));
  EXPECT_EQ(torso.params.solver.sweeps, 7);
  ASSERT_EQ(scene.incisions.size(), 2u);
  EXPECT_EQ(scene.incisions[0].blade.name, "first");
  EXPECT_EQ(scene.incisions[0].blade.from, (Vec3d{0.01, -0.1, 0.02}));
  EXPECT_EQ(scene.incisions[0].blade.depth, 0.012);
  EXPECT_EQ(scene.incisions[0].blade.start, 0.25);
  EXPECT_FALSE(scene.incisions[0].by_fraction);
  EXPECT_TRUE(scene.incisions[1].by_fraction);
  EXPECT_EQ(scene.incisions[1].blade.width, 0.01);
  EXPECT_EQ(scene.output.width, 320);
  EXPECT_EQ(scene.output.color, SkinColor::kStretch);
  EXPECT_EQ(scene.output.volume_rendering, "");
  EXPECT_EQ(scene.output.window, "bone");
  EXPECT_EQ(scene.output.deformed_size, (Int3{64, 64, 32}));
  EXPECT_FALSE(scene.output.obj);
}

// Every error is one sentence with its location, the expected and the found value.
TEST(Scene, ErrorsNameLocationAndExpectation) {
  struct Case {
    std::string text, error;
  };
  const std::vector<Case> cases = {
      {"", "s.toml:1:1: body is missing: a scene needs at least one body, as in [body.torso]"},
      {"[body]\n", "s.toml:1:1: body: a scene needs at least one body, as in [body.torso]"},
      {"[world\n", "s.toml:1:7: not TOML: "},
      {"[world]\n[body.a]\nct = \"\"\"a\nblock = 2\n\n",
       "s.toml:3: not TOML: a multi-line string that starts here is never closed"},
      {"[world]\nduration = 1\n[body.a]\nct = \"a.nii\nblock = 2\n",
       "s.toml:4: not TOML: a quote in this line is never closed"},
      {"# it's\n[body.a]\nct = 'a.nii # \n", "s.toml:3: not TOML: a quote in this line is never closed"},
      {small_scene("", "[camera.side]\nfrom = [0, 0, 0]\n"),
       "camera.side: at is missing: the point that it looks at, [x, y, z] [m]"},
      {small_scene("", "[camera.skin]\nfrom = [0, 0, 0]\nat = [1, 0, 0]\n"),
       "other pictures of the run have this name"},
      {small_scene("", "[camera.a]\nfrom = [1, 0, 0]\nat = [1, 0, 0]\n"), "from and at are the same point"},
      {small_scene("", "[wrold]\n"), "s.toml:5:2: wrold is not a key of a scene; did you mean world?"},
      {small_scene("skin = { tensoin = 3 }"),
       "s.toml:4:10: body.torso.skin.tensoin is not a key of a scene; did you mean tension?"},
      {small_scene("", "[world]\nduration = 0"),
       "s.toml:6:12: world.duration: expected a number between 0 and 3600 [s], found 0"},
      {small_scene("", "[world]\nduration = nan"),
       "world.duration: expected a number between 0 and 3600 [s], found nan"},
      {small_scene("", "[world]\nframe_rate = 2000"),
       "world.frame_rate: expected a number from 1 to 1000 [1/s], found 2000"},
      {small_scene("", "[world]\ngravity = [0, 1]"),
       "world.gravity: expected three numbers from -1000 to 1000 [m/s²], found [0, 1]"},
      {small_scene("", "[world]\ngravity = \"down\""),
       "world.gravity: expected three numbers from -1000 to 1000 [m/s²], found \"down\""},
      {"[body.torso]\nct = \"x\"\n", "s.toml:1:1: body.torso: model is missing: \"lattice\""},
      {"[body.torso]\nmodel = \"latice\"\nct = \"x\"\n",
       "s.toml:2:9: body.torso.model: expected \"lattice\", \"sfem\", \"rhombus\", \"cloth\", \"rigid\", "
       "found "
       "\"latice\"; did you "
       "mean "
       "\"lattice\"?"},
      {"[body.torso]\nmodel = \"lattice\"\n",
       "body.torso: ct is missing: a CT file or DICOM folder, or { phantom = \"torso\" }"},
      {"[body.torso]\nmodel = \"lattice\"\nct = \"\"\n",
       "body.torso.ct: expected the name of a file or folder, found \"\""},
      {"[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"foot\" }\n",
       "body.torso.ct.phantom: expected \"torso\", \"head\", \"leg\", found \"foot\""},
      {"[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"leg\", size = [2, 9, 9] }\n",
       "body.torso.ct.size: expected numbers from 8 to 2048 [voxels], found 2"},
      {small_scene("block = 0"), "body.torso.block: expected a whole number from 1 to 64 [voxels], found 0"},
      {small_scene("block = 2\nspacing = 0.004"),
       "body.torso.spacing: a body has either spacing or block, not both"},
      {small_scene("block = 2.5"),
       "body.torso.block: expected a whole number from 1 to 64 [voxels], found 2.5"},
      {small_scene("fixed = \"bones\""),
       "body.torso.fixed: expected \"bone\", \"ends\", [\"bone\", \"ends\"], \"none\", or { sides = "
       "\"back\", "
       "depth = 0.3 }, found \"bones\"; did you mean \"bone\"?"},
      {small_scene("fixed = { sides = \"behind\" }"), "body.torso.fixed.sides: expected \"right\", \"left\""},
      {small_scene("only = \"livre\""),
       "body.torso.only: expected a label's number (1 to 65535) or an organ's name, found \"livre\"; did you "
       "mean "
       "liver?"},
      {"[body.torso]\nmodel = \"lattice\"\nct = \"x\"\nonly = 5",
       "body.torso.only: a body of one label needs a segmentation: add labels = \"seg.nii.gz\""},
      {small_scene(
           "skin = false\nsolver = { method = \"pbd\" }",
           "[tool.a]\nbody = \"torso\"\nshape = { sphere = 0.01 }\npress = { at_fraction = [0.5, 0, 0.5] }"),
       "tool.a.body: torso has solver.method = \"pbd\", which has no contact forces in newtons"},
      {small_scene("tissue = { fat = -1 }"),
       "body.torso.tissue.fat: expected a number from 0.001 to 1e+12 [Pa], found -1"},
      {small_scene("tissue = { muscle = 1e100 }"),
       "body.torso.tissue.muscle: expected a number from 0.001 to 1e+12 [Pa], found 1e+100"},
      {small_scene("skin = { stiffness = 1e300 }"),
       "body.torso.skin.stiffness: expected a number from 1e-12 to 1e+12 [N/m], found 1e+300"},
      {small_scene("skin = { direction = [1e39, 0, 0] }"),
       "body.torso.skin.direction: expected numbers from -1e+12 to 1e+12 [1], found 1e+39"},
      {small_scene("solver = { damping = 1e-300 }"),
       "body.torso.solver.damping: expected a number from 0 to 1e+12 [1/s], found 1e-300, which is 0 in "
       "single "
       "precision"},
      {small_scene("tissue = { fat_max = -500 }"),
       "expected air_max < fat_max < bone_min, found -449 < -500 < 200 HU"},
      {small_scene("labels = \"s.nii\"\ntissue = { labels = { livre = 3e3 } }"),
       "body.torso.tissue.labels.livre: expected a label's number (1 to 65535) or an organ's name, found "
       "\"livre\"; did you mean liver?"},
      {"[body.torso]\nmodel = \"lattice\"\nct = \"x\"\ntissue = { labels = { liver = 3e3 } }",
       "stiffness by label needs a segmentation"},
      {small_scene("skin = { tension = 400 }"),
       "body.torso.skin.tension: expected less than the skin's stiffness, 300 N/m, found 400 N/m"},
      {small_scene("skin = { tension = [1, 2, 3] }"),
       "expected a number or [along, across] Langer's lines [N/m], found [1, 2, 3]"},
      {small_scene("skin = { law = \"fiber\" }\nsolver = { method = \"pbd\" }"),
       "solver.method = \"pbd\" offers the area law only"},
      {small_scene("skin = { direction = [0, 0, 0] }"),
       "body.torso.skin.direction: expected a vector that is not zero"},
      {small_scene("tissue = { law = \"solid\", volume = 2 }"),
       "tissue.volume: solid tissue, the default, keeps its volume by tissue.poisson"},
      {small_scene("tissue = { volume = 2 }"), "volume belongs to law = \"springs\": set that law"},
      {small_scene("tissue = { law = \"springs\", poisson = 0.3 }"),
       "tissue.poisson: springs have no Poisson's ratio"},
      {small_scene("tissue = { law = \"solid\", poisson = 0.5 }"), "tissue.poisson: expected"},
      {small_scene("tissue = { law = \"jelly\" }"),
       "tissue.law: expected \"springs\", \"solid\", \"exponential\", \"ogden\", found \"jelly\""},
      {small_scene("tissue = { law = \"solid\" }\nskin = false\nsolver = { method = \"pbd\" }"),
       "solver.method = \"pbd\" projects springs only"},
      {small_scene("tissue = { law = \"solid\" }\nsolver = { sweeps = 1 }"), "expected at least 2 sweeps"},
      {small_scene("solver = { method = \"xpbd\" }"),
       "solver.method: expected \"pbd\", \"vbd\", found \"xpbd\"; did you mean \"pbd\"?"},
      {small_scene("solver = { ordering = \"color\" }"),
       "solver.ordering: expected \"slabs\", \"colors\", found \"color\"; did you mean \"colors\"?"},
      {small_scene("", "[world]\ndevice = \"cuda\""),
       "world.device: expected \"cpu\", \"gpu\", found \"cuda\""},
      {small_scene("solver = { ordering = \"slabs\" }", "[world]\ndevice = \"gpu\""),
       "world.device = \"gpu\" needs solver.ordering = \"colors\""},
      {small_scene("skin = { law = \"area\" }\nsolver = { method = \"pbd\", ordering = \"slabs\" }",
                   "[world]\ndevice = \"gpu\""),
       "world.device = \"gpu\" needs solver.ordering = \"colors\""},
      {small_scene("solver = { sweeps = 1001 }"),
       "solver.sweeps: expected a whole number from 1 to 1000, found 1001"},
      {small_scene("", "[incision.a]\nfrom = [0,0,0]\nto = [1,0,0]"),
       "incision.a: body is missing: the name of the body that is cut"},
      {small_scene("", "[incision.a]\nbody = \"torsi\"\nfrom = [0,0,0]\nto = [1,0,0]"),
       "s.toml:6:8: incision.a.body: the scene has no body torsi with model = \"lattice\"; did you mean "
       "torso?"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]"),
       "incision.a: to or to_fraction is missing: the end of the cut"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [0,0,0]"),
       "incision.a.to: the cut has no length"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\npath = [[0,0,0]]"),
       "incision.a.path: expected at least two points [x, y, z], consecutive ones distinct, found"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\npath = [[0,0,0], [0,0,0]]"),
       "incision.a.path: expected at least two points"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\npath = [[0,0,0], [0,1]]"),
       "incision.a.path: expected at least two points"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\npath = [[0,0,0], [0,0,1]]\nto = [0,0,2]"),
       "incision.a.to: a cut has either from and to or a path, not both"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [0,0,1]\ntilt = 80"),
       "incision.a.tilt: expected a number from -75 to 75 [degrees], found 80"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\npath = [[0,0,0], [0,0,1]]\nwidth = 0.01"),
       "incision.a.width: a removed region is straight and upright"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [0,0,1]\ndepth = 0"),
       "incision.a.depth: expected a number between 0 and 1 [m], found 0"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [0,0,1]\ndepth = 12"),
       "incision.a.depth: expected a number between 0 and 1 [m], found 12 m; 12 mm are 0.012"},
      {small_scene("spacing = \"4 mm\""), "found \"4 mm\"; 4 mm are 0.004"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,-130,0]\nto = [0,0,1]"),
       "incision.a.from: expected numbers from -100 to 100 [m], found -130 m; -130 mm are -0.13"},
      {small_scene("", "[incision.a]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [0,0,1]\nstart = 2"),
       "incision.a.start: the cut starts at 2 s, after the end of the run at 2 s"},
      {small_scene("", "[output]\ndeformed_ct = \"../x.nii\""),
       "output.deformed_ct: expected a file name without folders"},
      {small_scene("", "[output]\ndeformed_ct = \"a.nii\"\njacobian = \"a.nii\""),
       "output.jacobian: output.deformed_ct and output.jacobian would be the same file, a.nii; expected "
       "different"},
      {small_scene("",
                   "[body.torso-b]\nmodel = \"lattice\"\nct = \"b.nii\"\n"
                   "[output]\ndeformed_ct = \"b-a.nii\"\njacobian = \"a.nii\""),
       "output.deformed_ct of body.torso and output.jacobian of body.torso-b would be the same file, "
       "torso-b-a.nii"},
      {small_scene("", "[incision.skin]\nbody = \"torso\"\nfrom = [0,0,0]\nto = [1,0,0]"),
       "incision.skin: pictures of the whole body have this name; expected another"},
      {small_scene("", "[output]\nwindow = \"abdomne\""), "did you mean \"abdomen\"?"},
      {small_scene("", "[output]\nsnapshots = { every = 0 }"),
       "output.snapshots.every: expected a number from 1e-12 to 1e+12 [s], found 0"},
      {small_scene("", "[output]\nsnapshots = { size = [10, 10] }"),
       "output.snapshots.size: expected numbers from 64 to 8192 [pixels], found 10"},
      {small_scene("", "[output]\nobj = 1"), "output.obj: expected true or false, found 1"},
  };
  for (const Case& c : cases)
    EXPECT_NE(error_of(c.text).find(c.error), std::string::npos) << error_of(c.text) << "\n  but expected\n"
                                                                 << c.error;
}

// All errors of a file are listed in its order.
TEST(Scene, ErrorsAreListedInFileOrder) {
  EXPECT_EQ(error_of(small_scene("block = 0", "[output]\nobj = 1")),
            "s.toml:4:9: body.torso.block: expected a whole number from 1 to 64 [voxels], found 0\n"
            "s.toml:6:7: output.obj: expected true or false, found 1");
}

// Snapshots are taken at the first frame, at the interval and at the last frame.
TEST(Scene, SnapshotFramesIncludeFirstAndLast) {
  const Result<Scene> scene = parse_scene(
      small_scene("", "[world]\nduration = 1.1\n[output]\nsnapshots = { every = 0.5 }"), "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  std::vector<int> frames;
  for (int frame = 0; frame <= frame_count(*scene); frame++)
    if (is_snapshot(*scene, frame)) frames.push_back(frame);
  EXPECT_EQ(frames, (std::vector<int>{0, 30, 60, 66}));
}

// Missing files, folders and files that are too large are refused by name.
TEST(Scene, RejectsForeignFiles) {
  const auto error = [](const std::string& path) { return read_scene(path).error().message; };
  EXPECT_EQ(error("/nowhere/s.toml"), "/nowhere/s.toml: does not exist; neither does the folder /nowhere");
  EXPECT_EQ(error("/tmp"), "/tmp: expected a scene file (.toml), found a folder");
  const std::string big = test::fresh_folder() / "big.toml";
  std::ofstream(big) << std::string(2 << 20, '#');
  EXPECT_EQ(error(big), big + ": expected a scene file (.toml), found more than 1 MiB");
}

// The scenes of the project are valid.
TEST(Scene, ProjectScenesAreValid) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TURGOR_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const Result<Scene> scene = read_scene(entry.path());
    EXPECT_TRUE(scene) << scene.error().message;
    count++;
  }
  EXPECT_GE(count, 3);
}

// Names consist of at most 64 letters, digits and a few signs.
TEST(Scene, NamesAreRestricted) {
  const std::string name = R"("x\nsystem(\"id\")\n#")";
  const std::string cloth = "[body.a]\nmodel = \"cloth\"\nsheet = { side = [1, 0, 0], up = [0, 0, 1] }\n";
  const std::string body = "[body.a]\nmodel = \"sfem\"\nblock = { size = [1, 1, 1], count = [2, 2, 2] }\n";
  const std::string press =
      "]\nbody = \"a\"\nshape = { sphere = 0.01 }\npress = { at_fraction = [0.5, 0.5, 1] }\n";
  const std::vector<std::string> scenes = {
      "[body." + name + "]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n",
      small_scene("", "[incision." + name + "]\nbody = \"torso\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\n"),
      body + "[tool." + name + press,
      body + "[body.a.inside." + name + "]\nlabel = 3\n",
      body + "[body.a.inclusion." + name + "]\ncenter = [0, 0, 0]\n",
      cloth + "[body.a.hold." + name + "]\nvertices = [1]\n",
      cloth + "[body.a.obstacle." + name + "]\nsphere = { center = [0, 0, 0], radius = 0.1 }\n"};
  for (const std::string& text : scenes) {
    const std::string error = error_of(text);
    EXPECT_NE(error.find("expected a name of at most 64 letters"), std::string::npos) << text << error;
    EXPECT_EQ(error.find("\nsystem"), std::string::npos) << "a name cannot add lines: " << error;
  }
}

// The error for an unknown key lists every known key once.
TEST(Scene, KnownKeysAreListedOnce) {
  const std::string error = error_of(small_scene("zzzzzzzz = 1"));
  ASSERT_NE(error.find("known are"), std::string::npos) << error;
  std::multiset<std::string> words;
  std::istringstream stream(error.substr(error.find("known are") + 9));
  for (std::string word; stream >> word;) words.insert(word.substr(0, word.find(',')));
  for (const std::string& word : words) EXPECT_EQ(words.count(word), 1u) << word << " in: " << error;
}

// Sizes that would fill the memory or the disk are refused before the run starts.
TEST(Scene, RejectsExcessiveSizes) {
  const auto error = [](const std::string& world, const std::string& output) {
    return error_of(small_scene("", "[world]\n" + world + "\n[output]\n" + output));
  };
  EXPECT_NE(error("duration = 3000\nframe_rate = 1000", "snapshots = { every = 10 }")
                .find("are 3000000 frames; expected at most 1000000"),
            std::string::npos);
  EXPECT_NE(error("duration = 1000", "snapshots = { every = 0.001 }").find("would leave 60000 snapshots"),
            std::string::npos);
  EXPECT_NE(error("", "snapshots = { size = [8192, 8192] }")
                .find("8192 x 8192 are 67.1 million pixels; expected at most 16.8 million"),
            std::string::npos);
  EXPECT_NE(error("", "deformed_size = [4096, 4096, 4096]")
                .find("are 68719 million voxels; expected at most 1074 million"),
            std::string::npos);
  EXPECT_EQ(error("duration = 1000\nframe_rate = 1000",
                  "snapshots = { every = 0.1, size = [4096, 4096] }\ndeformed_size = [1024, 1024, 1024]"),
            "no error");
}

// A DICOM series is selected by number or name.
TEST(Scene, SeriesByNumberOrName) {
  for (const char* series : {"2", "\"2\""}) {
    const Result<Scene> scene = parse_scene("[body.torso]\nmodel = \"lattice\"\nct = \"dicom\"\n", "s.toml",
                                            {std::string("body.torso.series=") + series});
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->lattice_bodies[0].ct.series, "2");
  }
  EXPECT_NE(
      error_of("[body.torso]\nmodel = \"lattice\"\nct = \"dicom\"\nseries = 0\n").find("body.torso.series"),
      std::string::npos);
}

}  // namespace
}  // namespace turgor
