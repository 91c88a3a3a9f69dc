#include "turgor/sim/scene/tissue_presets.hpp"

#include <algorithm>
#include <regex>
#include <set>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Every preset has a unique name, values with units, and states law, test, species and source.
TEST(TissuePresets, AreComplete) {
  std::set<std::string> names;
  for (const TissuePreset& preset : tissue_presets()) {
    EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
    for (const std::string& text : {preset.law, preset.test, preset.species, preset.source})
      EXPECT_FALSE(text.empty()) << preset.name;
    EXPECT_FALSE(preset.values.empty()) << preset.name;
    for (const PresetValue& value : preset.values) {
      EXPECT_FALSE(value.unit.empty()) << preset.name << ' ' << value.key;
      if (value.low < value.high) {
        EXPECT_LE(value.low, value.value) << preset.name << ' ' << value.key;
        EXPECT_GE(value.high, value.value) << preset.name << ' ' << value.key;
      }
    }
  }
  EXPECT_GE(names.size(), 40u);
}

// A citation names authors, a year, and in parentheses the journal with its volume, or the data set.
TEST(TissuePresets, SourcesAreExact) {
  const std::regex citation(R"(^[^0-9()]+ (19|20)[0-9][0-9] \([^)]*[0-9A-Z].*\).*$)");
  const auto is_data_set = [](const std::string& source) {
    return source.find("Database") != source.npos || source.find("ICMA") != source.npos;
  };
  for (const TissuePreset& preset : tissue_presets()) {
    EXPECT_TRUE(std::regex_match(preset.source, citation)) << preset.name << ": " << preset.source;
    const std::size_t open = preset.source.find('(');
    ASSERT_NE(open, std::string::npos) << preset.name;
    const std::string journal = preset.source.substr(open);
    EXPECT_TRUE(is_data_set(preset.source) || std::any_of(journal.begin(), journal.end(), ::isdigit))
        << preset.name << ": a journal has a volume, " << preset.source;
  }
}

// Presets that stiffen or relax have all values of their law: pairs with a sum of shares below 1 and
// ascending times, a modulus that is the static one, and skin with µ, b, k1, k2 and κ.
TEST(TissuePresets, LawsAreWhole) {
  int stiffening = 0, relaxing = 0, skin = 0;
  for (const TissuePreset& preset : tissue_presets()) {
    const auto has = [&](const char* key) { return find_value(preset, key) != nullptr; };
    const auto of = [&](const char* key) { return value_or(&preset, key, 0); };
    if (preset.kind == PresetKind::kSolid) {
      EXPECT_GT(of("young"), 0) << preset.name;
      stiffening += has("stiffening");
      EXPECT_FALSE(has("stiffening") && has("alpha")) << preset.name << " has one law";
      EXPECT_EQ(has("stiffening"), preset.law.starts_with("exponential")) << preset.name;
    }
    if (has("g1")) {
      relaxing++;
      EXPECT_LT(of("g1") + of("g2") + of("g3"), 0.999) << preset.name;
      EXPECT_LT(0, of("tau1")) << preset.name;
      if (has("g2")) {
        EXPECT_LT(of("tau1"), of("tau2")) << preset.name;
      }
      if (has("g3")) {
        EXPECT_LT(of("tau2"), of("tau3")) << preset.name;
      }
    }
    if (preset.kind != PresetKind::kSkin || preset.law != "exponential") continue;
    skin++;
    for (const char* key : {"shear", "stiffening", "fiber_stiffness", "fiber_stiffening", "dispersion"})
      EXPECT_TRUE(has(key)) << preset.name << ' ' << key;
  }
  EXPECT_EQ(stiffening, 4) << "muscle along and across the fibers, fat and muscle of limbs";
  EXPECT_EQ(relaxing, 3) << "fat, muscle along and across the fibers";
  EXPECT_EQ(skin, 2);
}

// Fabrics are the published numbers, typed again from the table of Wang, O'Brien and Ramamoorthi: density,
// the first row of the stretch table, and the first number of the first and third row of the bending table.
TEST(TissuePresets, FabricsArePublishedNumbers) {
  struct Published {
    const char* name;
    double density, stretch[4], bend_warp, bend_weft;
  };
  constexpr Published kPublished[] = {
      {"black-denim", 0.324, {205.352005, 10.234077, 1013.88629, 53.387184}, 6.4196457e-05, 9.6951576e-05},
      {"ponte-roma", 0.284, {31.146198, -12.802702, 44.028667, 31.896357}, 3.6348366e-05, 3.7157593e-05},
      {"interlock", 0.187, {16.593832, -14.69599, 34.477123, 36.860302}, 2.3191698e-05, 1.4267624e-05},
      {"rib-knit", 0.276, {42.871021, -0.234556, 65.166023, 83.175644}, 4.6237591e-05, 3.2243889e-05},
      {"sparkle-sweat", 0.224, {12.486332, -19.875324, 3.272434, 17.616289}, 5.9469658e-05, 4.5625023e-05}};
  for (const Published& fabric : kPublished) {
    const TissuePreset* preset = find_preset(fabric.name, PresetKind::kFabric);
    ASSERT_TRUE(preset) << fabric.name;
    const auto of = [&](const char* key) { return value_or(preset, key, -1); };
    const auto& [warp, cross, weft, shear] = fabric.stretch;
    EXPECT_EQ(of("density"), fabric.density) << fabric.name;
    EXPECT_EQ(of("warp"), warp) << fabric.name;
    EXPECT_EQ(of("weft"), weft) << fabric.name;
    EXPECT_EQ(of("shear"), shear) << fabric.name;
    EXPECT_DOUBLE_EQ(of("poisson"), std::max(cross, 0.0) / weft) << fabric.name;
    EXPECT_EQ(of("rigidity_warp"), fabric.bend_warp) << fabric.name;
    EXPECT_EQ(of("rigidity_weft"), fabric.bend_weft) << fabric.name;
  }
}

// Each kind finds its own presets, and chains also those of solids.
TEST(TissuePresets, KindsFindTheirOwn) {
  ASSERT_TRUE(find_preset("liver", PresetKind::kSolid));
  EXPECT_EQ(find_preset("liver", PresetKind::kSolid), find_preset("liver", PresetKind::kChain));
  EXPECT_FALSE(find_preset("zhang-2010", PresetKind::kSolid));
  EXPECT_TRUE(find_preset("zhang-2010", PresetKind::kChain));
  EXPECT_FALSE(find_preset("liver", PresetKind::kSkin));
  EXPECT_FALSE(find_preset("skin-upper-arm", PresetKind::kSolid));
  EXPECT_EQ(value_or(find_preset("skin-upper-arm", PresetKind::kSkin), "tension", 0), 5.6);
  EXPECT_EQ(value_or(find_preset("muscle-thigh", PresetKind::kSolid), "young", 0), 49750);
  EXPECT_EQ(value_or(nullptr, "young", 7), 7);
}

// Texts have the unit, and the scatter where one is stated.
TEST(TissuePresets, ValueTextShowsScatter) {
  EXPECT_EQ(value_text({"young", 51710, "Pa", 39880, 64320}), "51.71 kPa (39.88 to 64.32)");
  EXPECT_EQ(value_text({"young", 1e7, "Pa", 0, 0}), "10 MPa");
  EXPECT_EQ(value_text({"tension", 5.6, "N/m"}), "5.6 N/m");
  EXPECT_EQ(value_text({"alpha", -18.7, "1"}), "-18.7");
}

}  // namespace
}  // namespace turgor
