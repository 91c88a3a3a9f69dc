// Laws of skin in scenes.
#include "turgor/sim/scene/scene_skin.hpp"

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"

namespace turgor {
namespace {

constexpr const char* kLeg = "[body.b]\nmodel = \"lattice\"\nct = { phantom = \"leg\" }\n";

std::string skin_error(const std::string& skin) { return test::error_of(kLeg + skin); }

// The keys of the exponential law are read, and the report lists them with their source.
TEST(SceneSkin, ReadsExponentialLaw) {
  const LatticeScene scene =
      parse_scene(kLeg + std::string("[body.b.skin]\nlaw = \"exponential\"\ntension = [60, 30]\nshear = 80\n"
                                     "stiffening = 9\nfiber_stiffness = 200\nfiber_stiffening = 5\n"
                                     "dispersion = 0.1\n"),
                  "s.toml")
          ->lattice_bodies[0];
  const lattice::SkinParams& skin = scene.params.skin;
  EXPECT_EQ(skin.law, lattice::SkinLaw::kExponential);
  EXPECT_EQ(skin.tension_along, 60);
  EXPECT_EQ(skin.tension_across, 30);
  EXPECT_EQ(skin.shear, 80);
  EXPECT_EQ(skin.stiffening, 9);
  EXPECT_EQ(skin.fiber_stiffness, 200);
  EXPECT_EQ(skin.fiber_stiffening, 5);
  EXPECT_EQ(skin.dispersion, 0.1);
  int rows = 0;
  for (const TissueRow& row : scene.tissues)
    rows += row.component.starts_with("skin") && row.law == "exponential";
  EXPECT_EQ(rows, 3);
}

// Keys of other laws, and a tension beyond the law, are errors.
TEST(SceneSkin, RefusesKeysOfOtherLaws) {
  EXPECT_NE(skin_error("skin = { law = \"exponential\", stiffness = 300 }\n").find("remove stiffness"),
            std::string::npos);
  EXPECT_NE(
      skin_error("skin = { dispersion = 0.1 }\n").find("only skin.law = \"exponential\" has dispersion"),
      std::string::npos);
  EXPECT_NE(skin_error("skin = { law = \"exponential\", dispersion = 0.5 }\n").find("dispersion"),
            std::string::npos);
  EXPECT_NE(skin_error("skin = { law = \"exponential\", shear = 0 }\n").find("more than 0 N/m"),
            std::string::npos);
  EXPECT_NE(skin_error("skin = { law = \"exponential\", tension = 1e8 }\n").find("below 4"),
            std::string::npos);
  EXPECT_NE(
      skin_error("solver = { method = \"pbd\" }\nskin = { law = \"exponential\" }\n").find("area law only"),
      std::string::npos);
}

}  // namespace
}  // namespace turgor
