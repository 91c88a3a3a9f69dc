#include "turgor/io/mesh/unit_question.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// The unit is that in which the mesh has the size of an organ.
TEST(UnitQuestion, NamesMostUsualUnit) {
  EXPECT_EQ(unit_question(6.4), "6.4 m wide: is it in cm? scale = 0.01");
  EXPECT_EQ(unit_question(220), "220 m wide: is it in mm? scale = 0.001");
  EXPECT_EQ(unit_question(22), "22 m wide: is it in cm? scale = 0.01");
  EXPECT_EQ(unit_question(2e-4), "0.2 mm wide: is it in km? scale = 1000");
}

// A shirt of 0.88 m in centimeters is not taken for one in millimeters, as an organ of 88 units would be. No
// unit makes one of 11 units as wide as a garment.
TEST(UnitQuestion, GarmentsHaveSizesOfTheirOwn) {
  EXPECT_EQ(unit_question(88, Meshed::kGarment), "88 m wide: is it in cm? scale = 0.01");
  EXPECT_EQ(unit_question(88), "88 m wide: is it in mm? scale = 0.001");
  EXPECT_EQ(unit_question(880, Meshed::kGarment), "880 m wide: is it in mm? scale = 0.001");
  EXPECT_EQ(unit_question(11, Meshed::kGarment),
            "11 m wide, as no garment: scale = 0.073 makes it 0.8 m wide");
  EXPECT_EQ(unit_question(0.11, Meshed::kGarment), "");
}

// Organs, garments and tools cause no question, and no scale that was given does.
TEST(UnitQuestion, PlausibleSizesPass) {
  for (const double size : {0.002, 0.02, 0.2, 1.9}) EXPECT_EQ(unit_question(size), "") << size;
  const std::vector<Vec3d> wide{{0, 0, 0}, {6.4, 1, 1}};
  EXPECT_TRUE(check_unit("liver.obj", wide, true));
  const Status asked = check_unit("liver.obj", wide, false);
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().message,
            "liver.obj: 6.4 m wide: is it in cm? scale = 0.01 (scale = 1 if it is in meters)");
}

}  // namespace
}  // namespace turgor
