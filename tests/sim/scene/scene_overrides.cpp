// Overrides of a scene by --set.
#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {
namespace {

using test::error_of;

const std::string kFromFile =
    "[world]\nduration = 1.5\n[body.torso]\nmodel = \"lattice\"\nct = \"ct/patient.nii.gz\"\n";
const std::string kPhantom = "[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n";

// Overrides replace any key and accept words without quotes.
TEST(SceneOverrides, ReplaceKeysAndAcceptBareWords) {
  const Result<Scene> scene = parse_scene(kFromFile, "/scenes/s.toml",
                                          {"body.torso.ct=other/ct.nii.gz", "body.torso.skin.tension=20",
                                           "world.duration=3", "output.window=lung"});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->lattice_bodies[0].ct.file,
            "other/ct.nii.gz");  // relative to the current folder, not to the scene's folder
  EXPECT_EQ(scene->lattice_bodies[0].params.skin.tension_across, 20);
  EXPECT_EQ(scene->duration, 3);
  EXPECT_EQ(scene->output.window, "lung");
}

// Overrides replace a phantom by a file and a file by a phantom.
TEST(SceneOverrides, ReplacePhantomByFile) {
  const Result<Scene> file = parse_scene(kPhantom, "s.toml", {"body.torso.ct=2024"});
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->lattice_bodies[0].ct.file, "2024");
  EXPECT_FALSE(file->lattice_bodies[0].ct.phantom);
  const Result<Scene> phantom =
      parse_scene(kFromFile, "s.toml", {"body.torso.ct={ phantom = \"leg\", seed = 3 }"});
  ASSERT_TRUE(phantom) << phantom.error().message;
  EXPECT_EQ(phantom->lattice_bodies[0].ct.phantom->kind, PhantomKind::kLeg);
  EXPECT_EQ(phantom->lattice_bodies[0].ct.phantom->seed, 3);
}

// An index chooses an element of an array; elements that do not exist are refused.
TEST(SceneOverrides, IndicesChooseElementsOfArrays) {
  const std::string text =
      kPhantom +
      "viscosity = { pairs = [[0.4, 1], [0.2, 9]] }\n"
      "layers = [{ name = \"fat\", thickness = 0.01, young = 2e3 }, { name = \"rest\", young = 9e3 }]\n";
  const Result<Scene> scene =
      parse_scene(text, "s.toml",
                  {"body.torso.layers[1].young=5e3", "body.torso.layers[0].poisson=0.3",
                   "body.torso.viscosity.pairs[1]=[0.1, 3]"});
  ASSERT_TRUE(scene) << scene.error().message;
  const lattice::TissueParams& tissue = scene->lattice_bodies[0].params.tissue;
  EXPECT_EQ(tissue.layers[1].young, 5e3);
  EXPECT_EQ(tissue.layers[0].young, 2e3);
  EXPECT_EQ(tissue.layers[0].poisson, 0.3);
  EXPECT_EQ(tissue.prony.pairs[1].time, 3);
  const auto error = [&text](const std::string& one) { return error_of(text, {one}); };
  EXPECT_NE(error("body.torso.layers[2].young=1").find("the scene has no body.torso.layers[2]"),
            std::string::npos);
  EXPECT_NE(error("body.torso.viscosity.pairs[2]=[0.1, 1]").find("has no"), std::string::npos);
  EXPECT_NE(error("body.torso.layers[x].young=1").find("expected a key of names"), std::string::npos);
  EXPECT_NE(error("body.torso.layers[0.young=1").find("expected a key of names"), std::string::npos);
  EXPECT_NE(error("body.torso.layers[0].young=-1").find("--set body.torso.layers[0].young"),
            std::string::npos);
}

// Invalid overrides are refused by name.
TEST(SceneOverrides, RejectInvalidOverrides) {
  const auto error = [](const std::string& text) { return error_of(kFromFile, {text}); };
  EXPECT_EQ(error("world.duration"),
            "--set world.duration: expected key=value, as in --set body.torso.spacing=0.004");
  EXPECT_EQ(error("=3"), "--set =3: expected key=value, as in --set body.torso.spacing=0.004");
  EXPECT_EQ(error("world..duration=3"),
            "--set world..duration: expected a key of names with dots between them");
  EXPECT_EQ(error("world.duratoin=3"),
            "--set world.duratoin is not a key of a scene; did you mean duration?");
  EXPECT_EQ(error("body.torsso.block=3"),
            "--set body.torsso.block: the scene has no body torsso; did you mean torso?");
  EXPECT_EQ(error("body.torso.ct.seed=3"),
            "--set body.torso.ct.seed: body.torso.ct is \"ct/patient.nii.gz\" in the scene, not a table");
  EXPECT_EQ(error("world.duration=long"),
            "--set world.duration: expected a number between 0 and 3600 [s], found \"long\"");
  EXPECT_EQ(error("world.duration=3\nworld.x=4"),
            "--set world.duration: expected a number between 0 and 3600 [s], found "
            "\"3 world.x=4\"");
}

// A pair of overrides replaces the pair of the scene that says the same in other terms; half a pair does not.
TEST(SceneOverrides, PairReplacesFractions) {
  const std::string text =
      kPhantom +
      "spacing = 0.004\n[incision.cut]\nbody = \"torso\"\nfrom_fraction = [0.5, 0, 0.6]\n"
      "to_fraction = [0.5, 0, 0.2]\ndepth = 0.01\n";
  const Result<Scene> meters = parse_scene(
      text, "s.toml", {"incision.cut.from=[0.02, -0.11, 0.05]", "incision.cut.to=[0.02, -0.11, 0.15]"});
  ASSERT_TRUE(meters) << meters.error().message;
  EXPECT_FALSE(meters->incisions[0].by_fraction);
  EXPECT_EQ(meters->incisions[0].blade.from, (Vec3d{0.02, -0.11, 0.05}));
  EXPECT_EQ(meters->incisions[0].blade.to, (Vec3d{0.02, -0.11, 0.15}));
  const Result<Scene> curve = parse_scene(text, "s.toml", {"incision.cut.path=[[0, 0, 0], [0, 0, 0.1]]"});
  ASSERT_TRUE(curve) << curve.error().message;
  EXPECT_EQ(curve->incisions[0].blade.path.size(), 2u);
  const Result<Scene> block = parse_scene(text, "s.toml", {"body.torso.block=3"});
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_EQ(block->lattice_bodies[0].spacing, 0);
  const std::string half = error_of(text, {"incision.cut.from=[0, 0, 0]"});
  EXPECT_NE(half.find("either in meters or in fractions"), half.npos) << half;
  EXPECT_EQ(half.find('\n'), half.npos) << "one mistake, one message: " << half;
}

// The file of another shape replaces the shape of the scene; two shapes in the scene are one mistake.
TEST(SceneOverrides, ShapeReplacesShape) {
  const std::string text =
      "[body.liver]\nmodel = \"sfem\"\nlabels = { phantom = \"torso\", size = [64, 64, 40], spacing_mm = [6, "
      "6, 7] }\n"
      "label = \"liver\"\n";
  const Result<Scene> scene = parse_scene(text, "s.toml", {"body.liver.surface=own.obj"});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(std::holds_alternative<ClosedSurface>(scene->sfem_bodies.at(0).source));
  const std::string both = error_of(text + "surface = \"own.obj\"\n", {});
  EXPECT_NE(both.find("either surface or labels"), both.npos) << both;
  EXPECT_EQ(both.find('\n'), both.npos) << "one mistake, one message: " << both;
}

// An unknown model has one message, although nothing of the body can be read.
TEST(SceneOverrides, UnknownModelHasOneMessage) {
  const std::string text =
      kPhantom +
      "spacing = 0.004\n[incision.cut]\nbody = \"torso\"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\ndepth = 0.01\n";
  for (const char* model : {"body.torso.model=sfm", "body.torso.model=", "body.torso.model=3"}) {
    const std::string error = error_of(text, {model});
    EXPECT_NE(error.find("model"), error.npos) << error;
    EXPECT_EQ(error.find('\n'), error.npos) << error;
  }
}

// An override without a value removes its key.
TEST(SceneOverrides, EmptyValueRemovesKey) {
  const std::string text = kPhantom + "labels = \"seg.nii\"\n[output]\nwindow = \"bone\"\n";
  const Result<Scene> scene = parse_scene(text, "s.toml", {"body.torso.labels=", "output.window="});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->lattice_bodies[0].labels, "");
  EXPECT_EQ(scene->output.window, "abdomen") << "the default";
  EXPECT_EQ(error_of(text, {"body.torso.label="}),
            "--set body.torso.label=: the scene has no body.torso.label that could be removed; did you mean "
            "labels?");
  EXPECT_NE(error_of(text, {"body.torso.ct="}).find("ct is missing"), std::string::npos);
  EXPECT_NE(error_of(text, {"output.video="}).find("no output.video that could be removed"),
            std::string::npos);
}

// Relative files of overrides refer to the given folder, for every model.
TEST(SceneOverrides, RelativeFilesUseGivenFolder) {
  const std::string text =
      "[body.a]\nmodel = \"sfem\"\nmesh = \"in-file.msh\"\n[body.b]\nmodel = \"rhombus\"\nsurface = "
      "\"b.obj\"\n"
      "[body.c]\nmodel = \"cloth\"\nmesh = \"c.obj\"\n[tool.t]\nbody = \"a\"\nshape = { sphere = 0.01 "
      "}\npath = \"t.csv\"\n";
  const Result<Scene> scene =
      parse_scene(text, "/scenes/s.toml",
                  {"body.b.surface=my/b.obj", "body.c.mesh=my/c.obj", "tool.t.path=/abs/t.csv"}, "/then");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(std::get<SolidFile>(scene->sfem_bodies[0].source).file, "/scenes/in-file.msh");
  EXPECT_EQ(std::get<SurfaceFile>(scene->rhombus_bodies[0].source).file, "/then/my/b.obj");
  EXPECT_EQ(std::get<GarmentFile>(scene->cloth_bodies[0].source).file, "/then/my/c.obj");
  EXPECT_EQ(std::get<PathFile>(scene->tools[0].motion).file, "/abs/t.csv");
}

}  // namespace
}  // namespace turgor
