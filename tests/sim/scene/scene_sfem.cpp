#include "turgor/sim/scene/scene_sfem.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_cache.hpp"

namespace turgor {
namespace {

using test::error_of;

const std::string kSfemScene = R"(
[body.liver]
model = "sfem"
labels = "seg.nii.gz"
label = "liver"
resolution = 0.01
young = 5e3
poisson = 0.4
inside = { nodule = { label = 77, young = 4e4 } }
inclusion.cyst = { center_fraction = [0.5, 0.5, 0.5], radius = 0.02, young = 500, poisson = 0.3 }
fixed = { sides = ["back", "head"], depth = 0.2 }
formulation = "averaged"
patch = { radius = 0.03, refinement = 3, hysteresis = 0.5 }
viscosity = { ratio = 0.5, time = 0.3 }
precision = "double"
memory = 2
cache = "kept"
seen = "fine.obj"
seen_scale = 0.001

[body.pad]
model = "sfem"
block = { size = [0.1, 0.2, 0.3], count = [1, 2, 3] }
fixed = "bottom"
patch = false
cache = false

[tool.finger]
body = "pad"
shape = { sphere = 0.007 }
friction = 0.5
press = { at_fraction = [0.2, 0, 0.5], to_fraction = [0.8, 0, 0.5], depth = 0.01, start = 1, duration = 2, hold = 3, slide = 4 }

[tool.rod]
body = "liver"
shape = { capsule = [0.002, 0.03] }
path = [[0, 0, 0, 0], [1, 0.1, 0, 0, 1]]
interpolation = "linear"

[output]
color = "pressure"
)";

std::string small(const std::string& body = "block = { size = [1, 1, 1], count = [1, 1, 1] }",
                  const std::string& rest = "") {
  return "[body.b]\nmodel = \"sfem\"\n" + body + "\n" + rest;
}

std::string tool(const std::string& keys) { return small() + "\n[body.b.viscosity]\n[tool.t]\n" + keys; }

// Every key reaches its field.
TEST(SceneSfem, KeysReachFields) {
  const Result<Scene> scene = parse_scene(kSfemScene, "/data/s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->sfem_bodies.size(), 2u);
  const SfemScene& liver = scene->sfem_bodies[0];
  const auto& labels = std::get<LabeledOrgan>(liver.source);
  EXPECT_EQ(labels.file, "/data/seg.nii.gz");
  EXPECT_EQ(labels.label, 5);
  EXPECT_EQ(labels.resolution, 0.01);
  EXPECT_EQ(liver.material.young, 5e3);
  EXPECT_EQ(liver.inside[0].label, 77);
  EXPECT_EQ(liver.inside[0].material.young, 4e4);
  EXPECT_EQ(liver.inside[0].material.poisson, 0.4) << "missing values are those of the body";
  EXPECT_TRUE(liver.inclusions[0].by_fraction);
  EXPECT_EQ(liver.inclusions[0].material.poisson, 0.3);
  EXPECT_EQ(liver.fixed.sides, (std::vector<Side>{Side::kBack, Side::kHead}));
  EXPECT_EQ(liver.fixed.depth, 0.2);
  EXPECT_EQ(liver.formulation, sfem::Formulation::kAveraged);
  EXPECT_EQ(liver.precision, sfem::Precision::kDouble);
  EXPECT_EQ(liver.patch.radius, 0.03);
  EXPECT_EQ(liver.patch.refinement, 3);
  EXPECT_EQ(liver.viscosity, one_pair(0.5, 0.3));
  EXPECT_EQ(liver.memory, 2);
  EXPECT_EQ(liver.cache, std::filesystem::weakly_canonical(user_cache_folder()) / "kept");
  EXPECT_EQ(liver.seen, "/data/fine.obj");
  EXPECT_EQ(liver.seen_scale, 0.001);
  EXPECT_EQ(liver.elements, Elements::kLinear) << "default if a formulation is given";
  const SfemScene& pad = scene->sfem_bodies[1];
  EXPECT_EQ(pad.elements, Elements::kLinear) << "hexahedra";
  EXPECT_EQ(std::get<HexBlock>(pad.source).count, (Int3{1, 2, 3}));
  EXPECT_EQ(pad.patch.refinement, 1);
  EXPECT_FALSE(pad.cached);
  const ToolScene& finger = scene->tools[0];
  EXPECT_EQ(finger.body, (BodyId{BodyKind::kSfem, 1}));
  EXPECT_EQ(std::get<BallTool>(finger.shape).radius, 0.007);
  const Press& press = std::get<Press>(finger.motion);
  EXPECT_EQ(press.to.x, 0.8);
  EXPECT_EQ(press.start + press.duration + press.hold + press.slide, 10);
  const ToolScene& rod = scene->tools[1];
  EXPECT_EQ(rod.body, (BodyId{BodyKind::kSfem, 0}));
  EXPECT_EQ(std::get<RodTool>(rod.shape).half_length, 0.03);
  EXPECT_TRUE(std::get<GivenPath>(rod.motion).rows[1].hold);
  EXPECT_FALSE(std::get<GivenPath>(rod.motion).smooth);
  EXPECT_EQ(scene->output.color, SkinColor::kPressure);
}

// Errors name the key and its location in the file.
TEST(SceneSfem, ErrorsNameLocation) {
  const struct {
    std::string text, words;
  } cases[] = {
      {small("block = { size = [1, 1, 1], count = [1, 1, 1] }\nyoung = 1e100"),
       "body.b.young: expected a number from 0.001 to 1e+12 [Pa], found 1e+100"},
      {small("block = { size = [1e-300, 1, 1], count = [1, 1, 1] }"), ", which is 0 in single precision"},
      {small("young = 1"), "s.toml:1:1: body.b: mesh or surface or labels or block is missing"},
      {small("mesh = \"a.msh\"\nsurface = \"b.obj\""), "a body has one shape: either mesh or surface"},
      {small("labels = \"s.nii\""), "label is missing: the label of the body"},
      {small("labels = \"s.nii\"\nlabel = \"livre\""),
       "s.toml:4:9: body.b.label: expected a label's number (1 to 65535) or an organ's name, found "
       "\"livre\"; did "
       "you mean liver?"},
      {small("mesh = \"a.msh\"\nscale = 0"), "body.b.scale: expected a number between 0 and"},
      {small("mesh = \"a.msh\"\npoisson = 0.5"), "body.b.poisson: expected below 0.5"},
      {small("mesh = \"a.msh\"\npoisson = -1.2"), "between -1 and 0.5, found -1.2"},
      {small("mesh = \"a.msh\"\nfixed = \"below\""), "body.b.fixed: expected \"right\", \"left\""},
      {small("mesh = \"a.msh\"\nfixed = \"backk\""),
       "or \"head\" (or \"top\"); or \"none\", found \"backk\"; did you mean \"back\"?"},
      {small("mesh = \"a.msh\"\nfixed = \"nonne\""), "did you mean \"none\"?"},
      {small("mesh = \"a.msh\"\nfixed = { sides = [\"lefft\"] }"),
       "or \"head\" (or \"top\"), found \"lefft\"; did you mean \"left\"?"},
      {small("mesh = \"a.msh\"\nfixed = { box = [[0, 0, 0]] }"), "two corners, [[x, y, z], [x, y, z]]"},
      {small("mesh = \"a.msh\"\npatch = { refinement = 5 }"), "from 1 to 4, found 5"},
      {small("mesh = \"a.msh\"\nhue = 1"), "body.b.hue is not a key of a scene"},
      {small("mesh = \"a.msh\"\n[output]\ncolor = \"stretch\""), "stretch needs the skin of a lattice"},
      {tool("body = \"c\"\nshape = { sphere = 1 }\npath = [[0, 0, 0, 0]]"), "the scene has no body c"},
      {tool("body = \"b\"\npath = [[0, 0, 0, 0]]"), "shape is missing: as in { sphere = 0.006 } [m]"},
      {tool("body = \"b\"\nshape = { cube = 1 }\npath = [[0, 0, 0, 0]]"), "tool.t.shape.cube is not a key"},
      {tool("body = \"b\"\nshape = { sphere = 1, capsule = [1, 1] }\npath = [[0, 0, 0, 0]]"),
       "a tool has one shape: either sphere or capsule, not both"},
      {tool("body = \"b\"\nshape = { sphere = 1 }"),
       "path or press or grasp or hand is missing: how the tool moves"},
      {tool("body = \"b\"\nshape = { sphere = 1 }\npath = [[0, 0, 0, 0], [1, nan, 0, 0]]"),
       "s.toml:9:27: tool.t.path: expected numbers from -1e+12 to 1e+12 [s and m], found nan"},
      {tool("body = \"b\"\nshape = { sphere = 1 }\npath = [[0, 0, 0, 0], [0, 1, 0, 0]]"),
       "row 2 of the path: expected a time after that of the previous row"},
      {tool("body = \"b\"\nshape = { sphere = 1 }\npress = { depth = 0.1 }"), "at or at_fraction is missing"},
      {tool("body = \"b\"\nshape = { sphere = 1 }\npress = { at = [0, 0, 0], to_fraction = [0, 0, 0] }"),
       "either in meters or in fractions"},
  };
  for (const auto& c : cases)
    EXPECT_NE(error_of(c.text).find(c.words), std::string::npos)
        << c.text << "\nfound:    " << error_of(c.text) << "\nexpected: " << c.words;
}

// A tool with two motions is refused for that reason alone; neither key is called unknown.
TEST(SceneSfem, TwoMotions_AreRefusedOnce) {
  const std::string message = error_of(
      tool("body = \"b\"\nshape = { sphere = 1 }\npress = { at = [0, 0, 0] }\npath = [[0, 0, 0, 0]]"));
  EXPECT_EQ(message, "s.toml:9:9: tool.t.press: a tool has either a path or a press, not both");
}

// A scene chooses a cache below the user's cache folder only; an override may choose any folder.
TEST(SceneSfem, CacheStaysBelowUsersFolder) {
  const std::filesystem::path user = std::filesystem::weakly_canonical(user_cache_folder());
  const auto cache = [](const std::string& value) {
    return small("mesh = \"a.msh\"\ncache = \"" + value + "\"");
  };
  for (const char* outside : {"/any/where", "..", "liver/../../other", "/"})
    EXPECT_NE(
        error_of(cache(outside)).find("s.toml:4:9: body.b.cache: expected a folder below the user's cache"),
        std::string::npos)
        << outside << ": " << error_of(cache(outside));
  for (const std::string& inside : {std::string("liver"), std::string("a/../b"), (user / "liver").string()}) {
    const Result<Scene> scene = parse_scene(cache(inside), "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->sfem_bodies[0].cache, (user / inside).lexically_normal());
  }
  const Result<Scene> chosen = parse_scene(cache("liver"), "s.toml", {"body.b.cache=/any/where"});
  ASSERT_TRUE(chosen) << chosen.error().message;
  EXPECT_EQ(chosen->sfem_bodies[0].cache, "/any/where");
}

// A recording that names another folder, in its scene or its overrides, gets the user's cache and a note.
TEST(SceneSfem, RecordingKeepsToUsersCache) {
  const std::string plain = small("mesh = \"a.msh\""), outside = small("mesh = \"a.msh\"\ncache = \"/any\"");
  for (const auto& [text, overrides] : {std::pair(plain, std::vector<std::string>{"body.b.cache=/any"}),
                                        std::pair(outside, std::vector<std::string>{})}) {
    const Result<Scene> scene = parse_scene(text, "s.toml", overrides, "/recorded");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_TRUE(scene->sfem_bodies[0].cache.empty());
    ASSERT_EQ(scene->notes.size(), 1u);
    EXPECT_NE(scene->notes[0].find("folder /any is not below the user's cache folder"), std::string::npos);
  }
}

// Overrides do not create tools.
TEST(SceneSfem, OverridesCreateNoTools) {
  EXPECT_NE(error_of(kSfemScene, {"tool.fingr.friction=1"}).find("has no tool fingr; did you mean finger?"),
            std::string::npos);
}

// Gravity that acts on no body is noted. A body that is not held feels it.
TEST(SceneSfem, IdleGravityIsNoted) {
  const std::string world = "[world]\ngravity = [0, 0, -9.81]\n";
  const Result<Scene> held = parse_scene(world + small(), "s.toml");
  ASSERT_TRUE(held) << held.error().message;
  ASSERT_EQ(held->notes.size(), 1u);
  EXPECT_TRUE(held->notes[0].starts_with("world.gravity acts on no body of this scene")) << held->notes[0];
  const Result<Scene> falls = parse_scene(
      world + small("block = { size = [1, 1, 1], count = [1, 1, 1] }\nfixed = \"none\""), "s.toml");
  ASSERT_TRUE(falls) << falls.error().message;
  EXPECT_TRUE(falls->notes.empty());
}

// Tetrahedra are quadratic by default.
TEST(SceneSfem, TetrahedraDefaultToQuadratic) {
  const auto read = [](const std::string& keys) {
    const Result<Scene> scene = parse_scene(small(keys), "s.toml");
    EXPECT_TRUE(scene) << scene.error().message;
    return scene->sfem_bodies[0];
  };
  const SfemScene unsaid = read("surface = \"a.obj\"");
  EXPECT_EQ(unsaid.elements, Elements::kQuadratic);
  EXPECT_EQ(unsaid.patch.refinement, kByElements);
  EXPECT_FALSE(std::get<ClosedSurface>(unsaid.source).resolution) << "chosen by the volume";
  EXPECT_EQ(read("surface = \"a.obj\"\nelements = \"linear\"").elements, Elements::kLinear);
  EXPECT_EQ(read("surface = \"a.obj\"\nformulation = \"standard\"").elements, Elements::kLinear);
  EXPECT_NE(error_of(small("surface = \"a.obj\"\nelements = \"quadratic\"\nformulation = \"averaged\""))
                .find("one formulation, which does not lock"),
            std::string::npos);
  EXPECT_NE(
      error_of(small("block = { size = [1, 1, 1], count = [1, 1, 1] }\nelements = \"quadratic\""))
          .find("body.b.elements: \"quadratic\" elements are tetrahedra, a block consists of hexahedra"),
      std::string::npos);
}

}  // namespace
}  // namespace turgor
