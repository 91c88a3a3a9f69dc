#include "turgor/sim/tools/tool_path.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/folders.hpp"

namespace turgor {
namespace {

std::string error_of(const std::vector<std::vector<double>>& rows) {
  const auto path = path_rows(rows);
  return path ? "no error" : path.error().message;
}

// Rows have time, position, hold and orientation.
TEST(ToolPath, RowsHaveTimePoseAndHold) {
  const auto rows = path_rows({{0, 1, 2, 3}, {0.5, 4, 5, 6, 1}, {1, 7, 8, 9, 0, 2, 0, 0, 0}});
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ((*rows)[1].position, (Vec3d{4, 5, 6}));
  EXPECT_FALSE((*rows)[0].hold);
  EXPECT_TRUE((*rows)[1].hold);
  EXPECT_EQ((*rows)[2].orientation[0], 1) << "quaternions are normalized";
}

// Invalid rows are refused by number.
TEST(ToolPath, RejectsInvalidRows) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of({{0, 0, 0, 0}, {1, 0, nan, 0}}), "row 2 of the path: expected numbers, found nan");
  EXPECT_EQ(error_of({{0, 0, 0, 0}, {0.5, 0, 0, 0}, {0.4, 0, 0, 0}}),
            "row 3 of the path: expected a time after that of the previous row, 0.5 s, found 0.4 s");
  EXPECT_NE(error_of({{0, 0, 0}}).find("row 1 of the path: expected t, x, y, z"), std::string::npos);
  EXPECT_NE(error_of({}).find("found none"), std::string::npos);
  EXPECT_NE(error_of({{0, 0, 0, 0, 0, 0, 0, 0, 0}}).find("quaternion"), std::string::npos);
}

// Linear paths are straight and rest at their ends.
TEST(ToolPath, LinearPathIsClampedAtEnds) {
  const ToolPath path{*path_rows({{1, 0, 0, 0}, {2, 2, 0, 0}}), false};
  EXPECT_EQ(path_at(path, 0).position.x, 0);
  EXPECT_EQ(path_at(path, 1.25).position.x, 0.5);
  EXPECT_EQ(path_at(path, 7).position.x, 2);
}

// Smooth paths pass through every row and do not overshoot.
TEST(ToolPath, SmoothPathIsMonotone) {
  const ToolPath path{*path_rows({{0, 0, 0, 0}, {1, 1, 0, 0}, {2, 1, 0, 0}, {3, 5, 0, 0}}), true};
  double before = 0;
  for (int n = 0; n <= 300; n++) {
    const double x = path_at(path, n * 0.01).position.x;
    EXPECT_GE(x, before - 1e-12) << n;
    before = x;
  }
  for (const PathRow& row : path.rows) EXPECT_NEAR(path_at(path, row.time).position.x, row.position.x, 1e-12);
  // The speed is continuous: second differences shrink with the square of the interval.
  const auto bend = [&](double t, double h) {
    return std::abs(path_at(path, t + h).position.x - 2 * path_at(path, t).position.x +
                    path_at(path, t - h).position.x);
  };
  for (const double t : {1.0, 2.0}) EXPECT_LT(bend(t, 1e-4), 1e-6) << t;
}

// Files with column names are read; wrong lines are refused with their number.
TEST(ToolPath, ReadsFilesWithColumnNames) {
  const auto folder = test::fresh_folder();
  test::write(folder / "p.csv", "t,x,y,z\n0,1,2,3\r\n# a remark\n\n0.5; 4; 5; 6\n");
  const auto rows = read_path_rows(folder / "p.csv");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[1].position, (Vec3d{4, 5, 6}));
  test::write(folder / "units.csv", "t_ms,x_mm,y[cm],z (m),hold\n0,1,2,3,0\n500,4,5,6,1\n");
  const auto with_units = read_path_rows(folder / "units.csv");
  ASSERT_TRUE(with_units) << with_units.error().message;
  EXPECT_DOUBLE_EQ((*with_units)[1].time, 0.5);
  EXPECT_NEAR(norm((*with_units)[1].position - Vec3d{0.004, 0.05, 6}), 0, 1e-12);
  EXPECT_TRUE((*with_units)[1].hold);
  for (const char* header : {"t_s,x_furlong,y_mm,z_mm", "t (h),x,y,z", "t_s,x_N,y,z"}) {
    test::write(folder / "unknown.csv", std::string(header) + "\n0,1,2,3\n");
    const auto unknown = read_path_rows(folder / "unknown.csv");
    ASSERT_FALSE(unknown) << header;
    EXPECT_NE(unknown.error().message.find("unknown.csv: column"), std::string::npos)
        << unknown.error().message;
  }
  test::write(folder / "words.csv", "time,tool_x,tool_y,tool_z\n0,1,2,3\n");
  EXPECT_TRUE(read_path_rows(folder / "words.csv")) << "words that are no units";
  test::write(folder / "bad.csv", "0,1,2,3\n1,a,2,3\n");
  EXPECT_EQ(read_path_rows(folder / "bad.csv").error().message,
            (folder / "bad.csv").string() + ":2: expected numbers t, x, y, z, found \"1,a,2,3\"");
  test::write(folder / "nan.csv", "0,1,2,3\n1,nan,2,3\n");
  EXPECT_EQ(read_path_rows(folder / "nan.csv").error().message,
            (folder / "nan.csv").string() + ":2: expected numbers t, x, y, z, found \"1,nan,2,3\"");
}

// A rotation turns the tool axis to the normal.
TEST(ToolPath, AxisRotatesToNormal) {
  for (const Vec3d z : {Vec3d{0, 0, 1}, Vec3d{0, 0, -1}, Vec3d{0.6, -0.8, 0}, Vec3d{0.48, 0.6, 0.64}}) {
    const Mat3d axes = axes_of(turned_to(z));
    EXPECT_NEAR(norm(axes.column[2] - z), 0, 1e-12);
    EXPECT_NEAR(determinant(axes), 1, 1e-12);
    EXPECT_NEAR(dot(axes.column[0], axes.column[1]), 0, 1e-12);
  }
}

}  // namespace
}  // namespace turgor
