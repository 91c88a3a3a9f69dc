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
}

// A load cell that counts a press as negative would be fitted by a body without stiffness. Noise around zero
// may have any sign.
TEST(MeasuredForceTable, NegativePressIsRefused) {
  EXPECT_FALSE(check_measured({.at = {1, 2, 3}, .force = {0.01, -0.02, -0.05}}));
  EXPECT_TRUE(check_measured({.at = {1, 2, 3}, .force = {-0.01, 0.02, 0.05}}));
}

}  // namespace
}  // namespace turgor
