// Tables of forces are read with their units.
#include "turgor/sim/measured_force.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {
namespace {

// Wrong tables are refused with a sentence.
TEST(MeasuredForceTable, WrongInputIsRefused) {
  const auto folder = test::fresh_folder();
  const auto error_of = [&](const std::string& text) {
    EXPECT_TRUE(write_file(folder / "table.csv", text));
    const Result<MeasuredForce> read = read_measured_force(folder / "table.csv");
    return read ? std::string() : read.error().message;
  };
  EXPECT_NE(error_of("depth_mm,force_N\n1,0.1\n2,a\n").find("table.csv"), std::string::npos);
  EXPECT_NE(error_of("depth_mm,force_N\n1,0.1\n1,0.2\n").find("row 2"), std::string::npos);
  EXPECT_NE(error_of("depth_mm,force_kg\n1,0.1\n2,0.2\n").find("force_kg"), std::string::npos);
  EXPECT_NE(error_of("time_s,force_N\n-1,0.1\n2,0.2\n").find("row 1"), std::string::npos);
  EXPECT_NE(error_of("depth_mm,force_N\n1,0\n2,0\n").find("not zero"), std::string::npos);
  EXPECT_NE(error_of("1 2 3\n").find("two numbers"), std::string::npos);
  EXPECT_EQ(error_of("time_ms,force_mN\n1,100\n2,200\n"), "");
  EXPECT_NE(error_of("depth_mm,Force (stone)\n1,0.1\n2,0.2\n").find("found \"stone\""), std::string::npos);
  EXPECT_NE(error_of("depth_furlong,force_N\n1,0.1\n2,0.2\n").find("depth_furlong"), std::string::npos);
  EXPECT_NE(error_of("force_mN,depth_mm\n1,0.1\n2,0.2\n").find("depth_mm,force_N"), std::string::npos);
  EXPECT_NE(error_of("depth [mm] force [mN]\n1 0.1\n2 0.2\n").find("found 4 names"), std::string::npos);
  EXPECT_EQ(error_of("press of a liver\n0.001,0.1\n0.002,0.2\n"), "") << "a title";
}

// Units in brackets are applied, as after `_`.
TEST(MeasuredForceTable, ReadsUnitsOfEveryForm) {
  const auto folder = test::fresh_folder();
  for (const char* header : {"depth_mm,force_mN", "depth_mm,force [mN]", "Distance (mm);Force (mN)",
                             "Tiefe [mm]\tKraft in mN", "\"depth_mm\",\"force_mN\"", "depth/mm,force/mN"}) {
    ASSERT_TRUE(write_file(folder / "table.csv", std::string(header) + "\n1.5,20\n2,30\n"));
    const Result<MeasuredForce> read = read_measured_force(folder / "table.csv");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_FALSE(read->by_time) << header;
    EXPECT_DOUBLE_EQ(read->at[0], 1.5e-3) << header;
    EXPECT_DOUBLE_EQ(read->force[0], 0.02) << header;
    EXPECT_EQ(read->units, "mm, mN") << header;
  }
  for (const char* header : {"Time [ms],force_N", "Zeit in ms,Kraft in N", "t (ms),F (N)"}) {
    ASSERT_TRUE(write_file(folder / "table.csv", std::string(header) + "\n1.5,20\n2,30\n"));
    const Result<MeasuredForce> read = read_measured_force(folder / "table.csv");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(read->by_time) << header;
    EXPECT_DOUBLE_EQ(read->at[0], 1.5e-3) << header;
  }
}

// A load cell that counts a press as negative would be fitted by a body without stiffness. Noise around zero
// may have any sign.
TEST(MeasuredForceTable, NegativePressIsRefused) {
  EXPECT_FALSE(check_measured({.at = {1, 2, 3}, .force = {0.01, -0.02, -0.05}}));
  EXPECT_TRUE(check_measured({.at = {1, 2, 3}, .force = {-0.01, 0.02, 0.05}}));
}

}  // namespace
}  // namespace turgor
