#include "turgor/sim/scene/tissue_presets.hpp"

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
