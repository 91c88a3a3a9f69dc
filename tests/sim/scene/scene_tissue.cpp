// Presets in scenes: `tissue`, `skin` and `fabric` by name.
#include "turgor/sim/scene/scene_tissue.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/models/rhombus/tissues.hpp"

namespace turgor {
namespace {

using test::error_of;

constexpr const char* kLattice = "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n";
constexpr const char* kTissueOfSfem =
    "[body.b]\nmodel = \"sfem\"\nblock = { size = [1, 1, 1], count = [2, 2, 2] }\n";
constexpr const char* kTissueOfRhombus = "[body.b]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\n";
constexpr const char* kCloth = "[body.b]\nmodel = \"cloth\"\nsheet = { side = [1, 0, 0], up = [0, 1, 0] }\n";

Scene scene_of(const char* base, const std::string& lines, const std::vector<std::string>& overrides = {}) {
  return *parse_scene(base + lines, "s.toml", overrides);
}

const TissueRow* find_row(const std::vector<TissueRow>& rows, const std::string& component) {
  for (const TissueRow& row : rows)
    if (row.component == component) return &row;
  return nullptr;
}

// A preset sets the modulus and the viscosity of an sfem body; given keys win.
TEST(SceneTissue, SfemTakesPreset) {
  const SfemScene fat = scene_of(kTissueOfSfem, "tissue = \"fat\"\n").sfem_bodies[0];
  EXPECT_DOUBLE_EQ(fat.material.young, 1590);
  EXPECT_DOUBLE_EQ(fat.viscosity.pairs[0].ratio, 0.39 / 0.61);
  EXPECT_EQ(fat.viscosity.pairs[0].time, 700);
  EXPECT_EQ(pair_count(fat.viscosity), 1);
  const SfemScene given =
      scene_of(kTissueOfSfem, "tissue = \"fat\"\nyoung = 2e3\nviscosity = { ratio = 0, time = 3 }\n")
          .sfem_bodies[0];
  EXPECT_EQ(given.material.young, 2000);
  EXPECT_EQ(pair_count(given.viscosity), 0);
  EXPECT_EQ(given.viscosity.pairs[0].time, 3);
  const SfemScene nodule = scene_of(kTissueOfSfem,
                                    "tissue = \"liver\"\ninclusion.n = { center = [0, 0, 0], tissue = "
                                    "\"fibroadenoma\" }\n")
                               .sfem_bodies[0];
  EXPECT_EQ(nodule.material.young, 5400);
  EXPECT_EQ(nodule.inclusions[0].material.young, 6410);
}

// A lattice takes a preset in a short and a long form; keys of single tissues win.
TEST(SceneTissue, LatticeTakesPreset) {
  const auto params = [](const std::string& lines) {
    return scene_of(kLattice, lines).lattice_bodies[0].params;
  };
  for (const char* form : {"tissue = \"liver\"\n", "tissue = { preset = \"liver\" }\n"})
    for (const double young : {params(form).tissue.gas, params(form).tissue.muscle, params(form).tissue.bone})
      EXPECT_EQ(young, 5400) << form;
  const lattice::TissueParams mixed =
      params("tissue = { preset = \"muscle-thigh\", fat = 3e3, poisson = 0.4 }\n").tissue;
  EXPECT_EQ(mixed.fat, 3000);
  EXPECT_EQ(mixed.muscle, 49750);
  EXPECT_EQ(mixed.poisson, 0.4);
  EXPECT_EQ(params("skin = \"skin-forearm-high\"\n").skin.tension_across, 11.4);
  const lattice::SkinParams skin =
      params("skin = { preset = \"skin-forearm-high\", tension = [20, 10] }\n").skin;
  EXPECT_EQ(skin.tension_along, 20);
  EXPECT_EQ(skin.tension_across, 10);
}

// Chains of a preset are fitted to its modulus; the default is unchanged.
TEST(SceneTissue, RhombusTakesAnySolid) {
  const auto body = [](const std::string& lines) {
    return scene_of(kTissueOfRhombus, lines).rhombus_bodies[0];
  };
  EXPECT_DOUBLE_EQ(body("tissue = \"muscle-thigh\"\n").params.chain.normal,
                   rhombus::chain_of_modulus(49750).normal);
  EXPECT_EQ(body("tissue = \"fat\"\n").params.viscosity.pairs[0].time, 700);
  EXPECT_EQ(body("").tissue, "liver");
  EXPECT_EQ(body("").params.chain.normal, rhombus::tissues()[0].chain.normal);
  EXPECT_EQ(body("").params.viscosity.pairs[0].ratio, 0);
}

// A fabric preset sets the values of a sheet; given keys win.
TEST(SceneTissue, ClothTakesFabric) {
  const cloth::Fabric denim = scene_of(kCloth, "fabric = \"black-denim\"\n").cloth_bodies[0].params.fabric;
  EXPECT_EQ(denim.density, 0.324);
  EXPECT_EQ(denim.weft, 1013.88629);
  const cloth::Fabric given =
      scene_of(kCloth, "fabric = { preset = \"black-denim\", weft = 500 }\n").cloth_bodies[0].params.fabric;
  EXPECT_EQ(given.weft, 500);
  EXPECT_EQ(given.warp, denim.warp);
}

// Unknown names, names of another kind and other values are errors that name the key and suggest a name.
TEST(SceneTissue, ErrorsSuggestNames) {
  for (const char* base : {kLattice, kTissueOfSfem, kTissueOfRhombus}) {
    const std::string message = error_of(base + std::string("tissue = \"livre\"\n"));
    EXPECT_NE(message.find("s.toml:4:"), std::string::npos) << message;
    EXPECT_NE(message.find("body.b.tissue: expected the name of a tissue of `turgor tissues` (did you mean "
                           "\"liver\"?), found \"livre\""),
              std::string::npos)
        << message;
  }
  EXPECT_NE(
      error_of(kTissueOfSfem + std::string("tissue = \"skin-upper-arm\"\n")).find("found \"skin-upper-arm\""),
      std::string::npos);
  EXPECT_NE(error_of(kTissueOfSfem + std::string("tissue = 3\n")).find("expected the name of a tissue"),
            std::string::npos);
  EXPECT_NE(error_of(kLattice + std::string("tissue = 3\n")).find("expected a table"), std::string::npos);
  EXPECT_NE(error_of(kLattice + std::string("skin = \"skin-uper-arm\"\n")).find("skin-upper-arm"),
            std::string::npos);
  EXPECT_NE(error_of(kCloth + std::string("fabric = \"black-denin\"\n")).find("black-denim"),
            std::string::npos);
}

// Every row states whether a value is given, of a preset or a default, and cites the source.
TEST(SceneTissue, RowsStateSources) {
  const SfemScene liver = scene_of(kTissueOfSfem, "tissue = \"liver\"\n").sfem_bodies[0];
  const TissueRow* body = find_row(liver.tissues, "body");
  ASSERT_TRUE(body);
  EXPECT_EQ(body->law, "linear");
  EXPECT_EQ(body->values, "young 5.4 kPa, preset; poisson 0.45, default");
  EXPECT_NE(body->source.find("Physics in Medicine and Biology"), std::string::npos);
  EXPECT_NE(body->source.find("defaults of the program"), std::string::npos);

  // the scatter of measured skin tension stands beside the default
  const LatticeScene torso = scene_of(kLattice, "tissue = { fat = 3e3 }\n").lattice_bodies[0];
  const TissueRow* skin = find_row(torso.tissues, "skin");
  ASSERT_TRUE(skin);
  EXPECT_NE(skin->values.find("tension 45 N/m, default"), std::string::npos) << skin->values;
  EXPECT_NE(skin->source.find("6 to 138 N/m"), std::string::npos);
  const TissueRow* fat = find_row(torso.tissues, "fat");
  ASSERT_TRUE(fat);
  EXPECT_EQ(fat->values, "young 3 kPa, scene");
  EXPECT_EQ(fat->source, "the scene");
}

}  // namespace
}  // namespace turgor
