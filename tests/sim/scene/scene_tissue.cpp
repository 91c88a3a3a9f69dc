// Presets in scenes: `tissue`, `skin` and `fabric` by name.
#include "turgor/sim/scene/scene_tissue.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
#include "turgor/models/rhombus/chain.hpp"
#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/sim/world.hpp"

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

/// Law of a lattice that has all values of a preset.
const char* law_of(const TissuePreset& preset) {
  return find_value(preset, "stiffening") ? "exponential" : find_value(preset, "alpha") ? "ogden" : "solid";
}
int pairs_of(const TissuePreset& preset) {
  int count = 0;
  for (const char* key : {"g1", "g2", "g3"}) count += find_value(preset, key) != nullptr;
  return count;
}

// Every preset of a solid is read by lattices, elements and chains, with its modulus, its law and its pairs.
TEST(SceneTissue, EverySolidInEveryModel) {
  int seen = 0;
  for (const TissuePreset& preset : tissue_presets()) {
    if (preset.kind != PresetKind::kSolid) continue;
    seen++;
    const double young = value_or(&preset, "young", 0);
    const std::string viscosity = pairs_of(preset) > 0 ? "viscosity = {}\n" : "";
    const lattice::TissueParams tissue =
        scene_of(kLattice, fmt::format("tissue = {{ preset = \"{}\", law = \"{}\" }}\n{}", preset.name,
                                       law_of(preset), viscosity))
            .lattice_bodies[0]
            .params.tissue;
    EXPECT_EQ(tissue.muscle, young) << preset.name;
    EXPECT_EQ(tissue.stiffening, value_or(&preset, "stiffening", value_or(&preset, "alpha", 0)))
        << preset.name;
    EXPECT_EQ(pair_count(tissue.prony), pairs_of(preset)) << preset.name;
    const SfemScene sfem =
        scene_of(kTissueOfSfem, fmt::format("tissue = \"{}\"\n", preset.name)).sfem_bodies[0];
    EXPECT_EQ(sfem.material.young, young) << preset.name;
    EXPECT_EQ(pair_count(sfem.viscosity), pairs_of(preset)) << preset.name;
    const RhombusScene chains =
        scene_of(kTissueOfRhombus, fmt::format("tissue = \"{}\"\n", preset.name)).rhombus_bodies[0];
    EXPECT_TRUE(rhombus::build_chain(chains.params.chain)) << preset.name;
    EXPECT_EQ(chains.params.chain.normal, rhombus::chain_of_modulus(young).normal) << preset.name;
    EXPECT_EQ(pair_count(chains.params.viscosity), pairs_of(preset)) << preset.name;
  }
  EXPECT_GE(seen, 30);
}

// Every preset of skin is read by a lattice and bears its tension; those that stiffen set the law and its
// values.
TEST(SceneTissue, EverySkinInLattice) {
  for (const TissuePreset& preset : tissue_presets()) {
    if (preset.kind != PresetKind::kSkin) continue;
    const LatticeScene body =
        scene_of(kLattice, fmt::format("skin = \"{}\"\n", preset.name)).lattice_bodies[0];
    const lattice::SkinParams& skin = body.params.skin;
    const bool stiffens = preset.law == "exponential";
    EXPECT_EQ(skin.law, stiffens ? lattice::SkinLaw::kExponential : lattice::SkinLaw::kFiber) << preset.name;
    EXPECT_EQ(skin.tension_along, value_or(&preset, "tension", 45)) << preset.name;
    EXPECT_EQ(skin.shear, value_or(&preset, "shear", 100)) << preset.name;
    if (!stiffens) continue;
    EXPECT_EQ(skin.stiffening, value_or(&preset, "stiffening", -1)) << preset.name;
    EXPECT_EQ(skin.fiber_stiffness, value_or(&preset, "fiber_stiffness", -1)) << preset.name;
    EXPECT_EQ(skin.fiber_stiffening, value_or(&preset, "fiber_stiffening", -1)) << preset.name;
    EXPECT_EQ(skin.dispersion, value_or(&preset, "dispersion", -1)) << preset.name;
    EXPECT_TRUE(lattice::stretch_of_tension(skin)) << preset.name;
    const TissueRow* fibers = find_row(body.tissues, "skin, fibers");
    ASSERT_TRUE(fibers) << preset.name;
    EXPECT_NE(fibers->source.find(preset.source), std::string::npos) << fibers->source;
  }
  const std::string message = error_of(kLattice + std::string("skin = { preset = \"skin-porcine\", law = "
                                                              "\"fiber\" }\n"));
  EXPECT_NE(message.find("values of law = \"exponential\" only"), std::string::npos) << message;
}

// Every fabric is read by a cloth, and every chain as printed by chains alone.
TEST(SceneTissue, EveryFabricAndChain) {
  for (const TissuePreset& preset : tissue_presets()) {
    if (preset.kind == PresetKind::kFabric) {
      EXPECT_EQ(scene_of(kCloth, fmt::format("fabric = \"{}\"\n", preset.name))
                    .cloth_bodies[0]
                    .params.fabric.density,
                value_or(&preset, "density", -1))
          << preset.name;
    }
    if (preset.kind != PresetKind::kChain) continue;
    EXPECT_EQ(scene_of(kTissueOfRhombus, fmt::format("tissue = \"{}\"\n", preset.name))
                  .rhombus_bodies[0]
                  .params.chain.normal,
              value_or(&preset, "chain.normal", -1))
        << preset.name;
    EXPECT_NE(error_of(kTissueOfSfem + fmt::format("tissue = \"{}\"\n", preset.name)), "") << preset.name;
  }
}

// Muscle's three pairs reach the loaded bodies of all three models: the shares of the instantaneous stress.
TEST(SceneTissue, PairsReachBodies) {
  const TissuePreset& muscle = *find_preset("muscle-porcine-across", PresetKind::kSolid);
  const auto expect_pairs = [&](const Prony& prony, const char* model) {
    ASSERT_EQ(pair_count(prony), 3) << model;
    const double whole = 1 + total_ratio(prony);
    constexpr const char* kKeys[3][2] = {{"g1", "tau1"}, {"g2", "tau2"}, {"g3", "tau3"}};
    for (std::size_t i = 0; i < 3; i++) {
      EXPECT_NEAR(prony.pairs[i].ratio / whole, value_or(&muscle, kKeys[i][0], 0), 1e-12) << model;
      EXPECT_EQ(prony.pairs[i].time, value_or(&muscle, kKeys[i][1], 0)) << model;
    }
  };
  const auto world_of = [](const char* base, const std::string& lines) {
    Result<World> world = load_world(Exec(1), scene_of(base, lines));
    EXPECT_TRUE(world) << world.error().message;
    return std::move(*world);
  };
  const World torso =
      world_of(kLattice,
               "spacing = 0.02\nviscosity = {}\ntissue = { preset = \"muscle-porcine-across\", "
               "law = \"exponential\" }\n");
  expect_pairs(torso.lattice_bodies[0].model.params.tissue.prony, "lattice");
  EXPECT_EQ(torso.lattice_bodies[0].model.params.tissue.stiffening, 2.47);
  const World block = world_of(kTissueOfSfem, "tissue = \"muscle-porcine-across\"\ncache = false\n");
  expect_pairs(block.sfem_bodies[0].viscosity, "sfem");
  const World liver = world_of(kTissueOfRhombus, "tissue = \"muscle-porcine-across\"\n");
  expect_pairs(liver.rhombus_bodies[0].model.params.viscosity, "rhombus");
}

// Pairs of one preset beside the modulus of another; the report cites both. A preset without pairs, or pairs
// beside it, are errors.
TEST(SceneTissue, PairsOfAnotherPreset) {
  constexpr const char* kThigh =
      "tissue = \"muscle-thigh\"\nviscosity = { preset = \"muscle-porcine-across\" }\n";
  const LatticeScene torso = scene_of(kLattice, kThigh).lattice_bodies[0];
  EXPECT_EQ(torso.params.tissue.muscle, 49750);
  EXPECT_EQ(pair_count(torso.params.tissue.prony), 3);
  const TissueRow* pair = find_row(torso.tissues, "viscosity");
  ASSERT_TRUE(pair);
  EXPECT_NE(pair->source.find("Van Loocke"), std::string::npos) << pair->source;
  EXPECT_EQ(pair_count(scene_of(kTissueOfSfem, kThigh).sfem_bodies[0].viscosity), 3);
  EXPECT_EQ(pair_count(scene_of(kTissueOfRhombus, kThigh).rhombus_bodies[0].params.viscosity), 3);
  EXPECT_NE(error_of(kTissueOfSfem + std::string("viscosity = { preset = \"liver\" }\n"))
                .find("expected a preset with Prony pairs"),
            std::string::npos);
  EXPECT_NE(error_of(kLattice + std::string("tissue = \"muscle-thigh\"\nviscosity = {}\n"))
                .find("preset muscle-thigh, which has none"),
            std::string::npos)
      << "it would not relax";
  EXPECT_NE(error_of(kTissueOfSfem + std::string("viscosity = { preset = \"fat\", ratio = 1 }\n"))
                .find("the pairs are those of preset"),
            std::string::npos);
}

// A body of elements with a law takes the stiffening of its preset, and none of its pairs, which a law
// excludes.
TEST(SceneTissue, SfemLawTakesStiffening) {
  const std::string muscle = "tissue = \"muscle-porcine-along\"\nlaw = \"exponential\"\n";
  const SfemScene body = scene_of(kTissueOfSfem, muscle).sfem_bodies[0];
  ASSERT_TRUE(body.law);
  EXPECT_EQ(body.law->stiffening, 3.25);
  EXPECT_EQ(pair_count(body.viscosity), 0);
  const TissueRow* law = find_row(body.tissues, "body, law of the patch");
  ASSERT_TRUE(law);
  EXPECT_EQ(law->values, "stiffening 3.25, preset");
  EXPECT_EQ(scene_of(kTissueOfSfem, muscle + "stiffening = 8\n").sfem_bodies[0].law->stiffening, 8);
  EXPECT_NE(error_of(kTissueOfSfem + muscle + "viscosity = { preset = \"fat\" }\n").find("viscosity"),
            std::string::npos);
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
