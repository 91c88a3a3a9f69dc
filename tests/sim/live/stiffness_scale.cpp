// Stiffness of whole bodies, scaled at loading and in a running world.
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/four_kinds.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/requests.hpp"

namespace turgor {
namespace {

const Exec kOneExec(1);

World loaded(const std::vector<std::string>& overrides) {
  const Scene scene = test::four_kinds_scene(test::fresh_folder(), overrides);
  Result<World> world = load_world(kOneExec, scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

void run_frames(World& world, int frames) {
  for (int n = 0; n < frames; n++) ASSERT_TRUE(step(kOneExec, world));
}

const std::vector<std::string> kScaled = {"body.pad.stiffness_scale=4", "body.liver.stiffness_scale=4",
                                          "body.block.stiffness_scale=4", "body.sheet.stiffness_scale=4"};

// A body whose stiffness is changed gives the same bits as one that was loaded with it.
TEST(StiffnessScale, ChangedBodyEqualsLoadedBody) {
  auto scene = std::make_shared<const Scene>(test::four_kinds_scene(test::fresh_folder()));
  World changed = loaded({});
  for (const std::string& one : kScaled) {
    const std::size_t equals = one.find('=');
    ASSERT_TRUE(apply_request(kOneExec, ChangeRequest{one.substr(0, equals), one.substr(equals + 1)}, scene,
                              changed));
  }
  World scaled = loaded(kScaled), plain = loaded({});
  run_frames(changed, 8), run_frames(scaled, 8), run_frames(plain, 8);
  EXPECT_EQ(state_hash(changed), state_hash(scaled));
  EXPECT_NE(state_hash(changed), state_hash(plain));
}

double largest_force(const World& world, int tool) {
  double largest = 0;
  for (const ForceSample& sample : world.tools[std::size_t(tool)].samples)
    largest = std::max(largest, norm(sample.force));
  return largest;
}

// The same press meets four times the force in both models that are ticked.
TEST(StiffnessScale, PressForceScales) {
  const std::vector<std::string> no_cloth = {"body.sheet.sheet.corner=[0, 0, 0.2]"};
  std::vector<std::string> with = kScaled;
  with.insert(with.end(), no_cloth.begin(), no_cloth.end());
  World plain = loaded(no_cloth), scaled = loaded(with);
  run_frames(plain, 8), run_frames(scaled, 8);
  for (const int tool : {test::kFinger, test::kBall}) {
    const double force = largest_force(plain, tool);
    EXPECT_GT(force, 0.01) << "N";
    EXPECT_NEAR(largest_force(scaled, tool), 4 * force, 4e-3 * force) << tool;
  }
}

// A scaled lattice has the moduli of one whose tissue is as stiff; a scaled cloth has those of a stiffer
// fabric.
TEST(StiffnessScale, ModelsHaveScaledModuli) {
  const World scaled = loaded(kScaled);
  const World stiff =
      loaded({"body.block.tissue.gas=4e3", "body.block.tissue.fat=2e4", "body.block.tissue.muscle=8e4",
              "body.block.tissue.bone=4e7", "body.sheet.fabric.warp=4000", "body.sheet.fabric.weft=4000",
              "body.sheet.fabric.shear=800", "body.sheet.fabric.bend=80"});
  const World plain = loaded({"body.sheet.fabric.warp=1000", "body.sheet.fabric.weft=1000",
                              "body.sheet.fabric.shear=200", "body.sheet.fabric.bend=20"});
  const auto &a = scaled.lattice_bodies[0].model.anatomy.cell_young,
             &b = stiff.lattice_bodies[0].model.anatomy.cell_young,
             &c = plain.lattice_bodies[0].model.anatomy.cell_young;
  ASSERT_EQ(a.size(), b.size());
  int cells = 0;
  for (std::size_t n = 0; n < a.size(); n++) {
    EXPECT_NEAR(double(a[n]), double(b[n]), 1e-5 * double(b[n]));
    cells += c[n] > 0;
  }
  EXPECT_GT(cells, 100);
  const auto &rows = scaled.cloth_bodies[0].model.rows, &stiff_rows = stiff.cloth_bodies[0].model.rows;
  ASSERT_EQ(rows.stiffness.size(), stiff_rows.stiffness.size());
  for (std::size_t n = 0; n < rows.stiffness.size(); n++)
    EXPECT_NEAR(double(rows.stiffness[n]), double(stiff_rows.stiffness[n]),
                1e-5 * double(stiff_rows.stiffness[n]));
}

// A sheet by its membrane and bending law scales too.
TEST(StiffnessScale, SheetLawScales) {
  const std::string text =
      "[world]\n[body.a]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.1, 0, 0], "
      "up = [0, 0.1, 0], columns = 6, rows = 6 }\n";
  const auto model_of = [&text](const std::vector<std::string>& overrides) {
    Result<World> world = load_world(kOneExec, *parse_scene(text, "a.toml", overrides));
    EXPECT_TRUE(world) << world.error().message;
    return std::move(world->cloth_bodies[0].model);
  };
  const cloth::Model plain = model_of({}), scaled = model_of({"body.a.stiffness_scale=3"});
  const cloth::Fabric& f = plain.params.fabric;
  const auto times_3 = [](const char* key, double value) {
    return "body.a.fabric." + std::string(key) + "=" + std::to_string(3 * value);
  };
  const cloth::Model stiff =
      model_of({times_3("warp", f.warp), times_3("weft", f.weft), times_3("shear", f.shear),
                times_3("rigidity_warp", f.rigidity_warp), times_3("rigidity_weft", f.rigidity_weft)});
  EXPECT_NEAR(double(scaled.membrane.law.warp), double(stiff.membrane.law.warp),
              1e-4 * double(stiff.membrane.law.warp));
  EXPECT_NEAR(double(scaled.membrane.law.both), double(stiff.membrane.law.both),
              1e-4 * std::abs(double(stiff.membrane.law.both)) + 1e-9);
  const auto same = [](const aligned_vector<Real>& a, const aligned_vector<Real>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t n = 0; n < a.size(); n++)
      EXPECT_NEAR(double(a[n]), double(b[n]), 1e-3 * std::abs(double(b[n])) + 1e-9);
  };
  same(scaled.rows.stiffness, stiff.rows.stiffness);
  same(scaled.rows.bend, stiff.rows.bend);
  same(scaled.far_rows.stiffness, stiff.far_rows.stiffness);
  same(scaled.extra_diagonal, stiff.extra_diagonal);
}

// Inclusions do not hinder the change; projections and a GPU do.
TEST(StiffnessScale, ReasonsDependOnModel) {
  const auto waits = [](const std::string& body, const std::string& key) {
    const Result<Scene> scene = parse_scene("[world]\n[body.a]\n" + body, "a.toml");
    EXPECT_TRUE(scene) << scene.error().message;
    for (const SceneKey& one : scene_keys(scene->text, scene->file))
      if (one.path == key) return why_not_live(*scene, one);
    return std::string("no such key");
  };
  const std::string block =
      "model = \"sfem\"\nblock = { size = [1, 1, 1], count = [2, 2, 2] }\n"
      "inclusion.stone = { center = [0.5, 0.5, 0.5], young = 1e5 }\n";
  EXPECT_EQ(waits(block, "body.a.stiffness_scale"), "");
  EXPECT_NE(waits(block, "body.a.young"), "");
  EXPECT_EQ(waits("model = \"rhombus\"\nsurface = { phantom = \"liver\" }\n", "body.a.stiffness_scale"), "");
  const std::string torso = "model = \"lattice\"\nct = { phantom = \"torso\" }\n";
  EXPECT_EQ(waits(torso, "body.a.stiffness_scale"), "");
  EXPECT_EQ(
      waits(torso + "solver = { method = \"pbd\" }\nskin = { law = \"area\" }\n", "body.a.stiffness_scale"),
      "projections have no moduli");
}

}  // namespace
}  // namespace turgor
