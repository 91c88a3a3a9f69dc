#include "turgor/sim/tools/force_curve.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

class ForceCurve : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) {
    test::write(folder_ / "curve.csv", text);
    return folder_ / "curve.csv";
  }
  std::string message(const std::string& text) {
    const auto curve = read_force_curve(file(text));
    return curve ? "read" : curve.error().message.substr((folder_ / "").string().size());
  }
  std::filesystem::path folder_ = test::fresh_folder();
};

// Column names, comments and any separator are accepted.
TEST_F(ForceCurve, ReadsNamesCommentsAndSeparators) {
  const auto curve = *read_force_curve(
      file("depth_m,force_N\r\n# at 1 mm/s\r\n0,0\r\n\r\n0.001; 0.02\n0.002\t0.05\n 0.003 0.09"));
  ASSERT_EQ(curve.size(), 4u);
  EXPECT_EQ(curve[1].depth, 0.001);
  EXPECT_EQ(curve[3].force, 0.09);
}

// Units in the column names are applied.
TEST_F(ForceCurve, AppliesUnitsOfColumns) {
  for (const char* header : {"depth_mm,force_mN", "Eindringtiefe[mm];Kraft[mN]", "d(mm)\tF(mN)"}) {
    const auto curve = read_force_curve(file(std::string(header) + "\n1.5 20\n"));
    ASSERT_TRUE(curve) << header << ": " << curve.error().message;
    EXPECT_DOUBLE_EQ((*curve)[0].depth, 0.0015) << header;
    EXPECT_DOUBLE_EQ((*curve)[0].force, 0.02) << header;
  }
  EXPECT_EQ((*read_force_curve(file("depth force\n0.002 3\n")))[0].depth, 0.002)
      << "other words are not units";
  EXPECT_EQ(message("force_N,depth_mm\n1,2\n"),
            "curve.csv: expected a depth before its force, found the columns \"force_N\" and \"depth_mm\"");
}

// Kilonewtons and grams of force are applied; unknown units are refused with the column and the known ones.
TEST_F(ForceCurve, RefusesUnknownUnits) {
  EXPECT_DOUBLE_EQ((*read_force_curve(file("depth_mm,force_kN\n1,0.02\n")))[0].force, 20);
  EXPECT_DOUBLE_EQ((*read_force_curve(file("Distance (mm),Force (g)\n1,5\n")))[0].force, 5 * 9.80665e-3);
  EXPECT_EQ(*force_curve_units(file("Distance (mm),Force (g)\n1,5\n")), "mm, g");
  EXPECT_EQ(*force_curve_units(file("1,5\n")), "m, N");
  EXPECT_EQ(message("Distance (mm),Force (stone)\n1,5\n"),
            "curve.csv: column \"Force (stone)\": expected a unit of force (N, kN, cN, mN, uN, g, gf, kgf), "
            "found \"stone\"");
  EXPECT_EQ(message("x_furlong,force_N\n1,5\n"),
            "curve.csv: column \"x_furlong\": expected a unit of length (m, cm, mm, um, µm, μm), found "
            "\"furlong\"");
  EXPECT_EQ(message("depth [mm] force [mN]\n1 5\n"),
            "curve.csv: expected the names of two columns, a depth and a force, found 4");
}

// Every spelling of the micrometer is recognized.
TEST_F(ForceCurve, ReadsEverySpellingOfMicrometer) {
  for (const char* header :
       {"depth_um,force_N", "depth_µm,force_N", "Tiefe [μm];Kraft [N]", " Tiefe in μm , Kraft in N \r"}) {
    const auto curve = read_force_curve(file(std::string(header) + "\n1500 20\n"));
    ASSERT_TRUE(curve) << header << ": " << curve.error().message;
    EXPECT_DOUBLE_EQ((*curve)[0].depth, 0.0015) << header;
  }
}

// Invalid lines are refused with their line number.
TEST_F(ForceCurve, RejectsInvalidLines) {
  EXPECT_EQ(message("depth,force\n0,0\n0.001,abc\n"),
            "curve.csv:3: expected two numbers, a depth [m] and a force [N], found \"0.001,abc\"");
  EXPECT_EQ(message("0,0,0\n"),
            "curve.csv:1: expected two numbers, a depth [m] and a force [N], found \"0,0,0\"");
  EXPECT_EQ(message("0 nan\n0 0\n"),
            "curve.csv:1: expected two numbers, a depth [m] and a force [N], found \"0 nan\"");
  EXPECT_EQ(message("0 0\n0 inf\n"),
            "curve.csv:2: expected two numbers, a depth [m] and a force [N], found \"0 inf\"");
  EXPECT_EQ(message("names\n"),
            "curve.csv: expected lines of two numbers, a depth [m] and a force [N], found none");
  EXPECT_FALSE(read_force_curve(folder_ / "missing.csv"));
}

}  // namespace
}  // namespace turgor
