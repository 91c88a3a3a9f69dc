#include "turgor/io/volume/nrrd_grid.hpp"

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {
namespace {

/// Grid of 2 x 2 x 2 bytes with these fields.
Result<Grid> grid_of(const std::string& fields) {
  const auto file = test::fresh_folder() / "a.nrrd";
  test::write(file,
              "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n" + fields + "\n12345678");
  const auto raw = read_volume_file(file);
  if (!raw) return raw.error();
  return raw->grid;
}

/// Checks the position of sample (0, 0, 0) and the step along each axis [mm].
void expect_grid(const std::string& fields, Vec3d first, Vec3d i, Vec3d j, Vec3d k) {
  const auto grid = grid_of(fields);
  ASSERT_TRUE(grid) << grid.error().message;
  EXPECT_LT(norm(point_at(*grid, {}) * 1e3 - first), 1e-9) << fields;
  EXPECT_LT(norm(point_at(*grid, {1, 0, 0}) * 1e3 - first - i), 1e-9) << fields;
  EXPECT_LT(norm(point_at(*grid, {0, 1, 0}) * 1e3 - first - j), 1e-9) << fields;
  EXPECT_LT(norm(point_at(*grid, {0, 0, 1}) * 1e3 - first - k), 1e-9) << fields;
}

const std::string kGridFields =
    "space directions: (0.6,0.8,0) (-1.6,1.2, 0) ( 0 , 0 , 2.5e0 )\nspace origin: (1,2,3)\n";

// The space field determines the frame of origin and directions.
TEST(NrrdGrid, SpaceSetsPatientFrame) {
  for (const char* lps : {"space: left-posterior-superior\n", "space: LPS\n", "space: scanner-xyz\n",
                          "space: 3D-right-handed\n", "space dimension: 3\n"})
    expect_grid(lps + kGridFields, {1, 2, 3}, {0.6, 0.8, 0}, {-1.6, 1.2, 0}, {0, 0, 2.5});
  for (const char* ras : {"space: right-anterior-superior\n", "space: RAS\n"})
    expect_grid(ras + kGridFields, {-1, -2, 3}, {-0.6, -0.8, 0}, {1.6, -1.2, 0}, {0, 0, 2.5});
  for (const char* las :
       {"space: left-anterior-superior\n", "space: LAS\n"})  // only anterior and posterior are swapped
    expect_grid(las + kGridFields, {1, -2, 3}, {0.6, -0.8, 0}, {-1.6, -1.2, 0}, {0, 0, 2.5});
}

// Without a space field the grid is aligned with the patient axes.
TEST(NrrdGrid, WithoutSpaceUsesPatientAxes) {
  const Vec3d i{0.5, 0, 0}, j{0, 2, 0}, k{0, 0, 3};
  expect_grid("", {}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  expect_grid("spacings: 0.5 2 3\n", {}, i, j, k);
  expect_grid("spacings: 0.5 2 3\naxis mins: 1 2 3\n", {1.25, 3, 4.5}, i, j, k);
  expect_grid("spacings: 0.5 2 3\naxis mins: 1 2 3\ncenterings: cell node cell\n", {1.25, 2, 4.5}, i, j, k);
}

// A field that leaves the grid ambiguous is rejected and named.
TEST(NrrdGrid, AmbiguousFieldIsNamed) {
  const std::string lps = "space: LPS\n";
  EXPECT_REFUSED(grid_of("space: right-posterior-inferior\n" + kGridFields), "right-posterior-inferior");
  EXPECT_REFUSED(grid_of("space: 3D-left-handed\n" + kGridFields), "3D-left-handed");
  EXPECT_REFUSED(grid_of("space: RAST\n" + kGridFields), "RAST");
  EXPECT_REFUSED(grid_of("space dimension: 4\n" + kGridFields), "space");
  EXPECT_REFUSED(grid_of(kGridFields), "space");
  EXPECT_REFUSED(grid_of(lps + kGridFields + "spacings: 1 1 1\n"), "spacings");
  EXPECT_REFUSED(grid_of(lps + kGridFields + "axis mins: 1 1 1\n"), "axis mins");
  EXPECT_REFUSED(grid_of(lps + kGridFields + "space units: \"m\" \"m\" \"m\"\n"), "space units", "mm");
  EXPECT_TRUE(grid_of(lps + kGridFields + "space units: \"mm\" \"mm\" \"mm\"\n"));
  EXPECT_REFUSED(grid_of("spacings: 1 1 1\nunits: \"cm\" \"cm\" \"cm\"\n"), "units", "mm");
  EXPECT_REFUSED(grid_of("axis mins: 1 1 1\naxis maxs: 3 3 3\n"), "axis mins", "spacings");
  EXPECT_REFUSED(grid_of("spacings: 1 1\n"), "spacings: 1 1", "3 finite numbers");
  for (const char* directions :
       {"(1,0,0) (0,1,0)", "(1,0) (0,1) (0,0)", "(1,0,0) (0,1,0) none", "none (1,0,0) (0,1,0) (0,0,1)",
        "(1,0,0", "(1,0,0) x (0,1,0) (0,0,1)", "(1,0,0) (0,1,0) (0,0,inf)"})
    EXPECT_REFUSED(grid_of(lps + "space directions: " + directions + "\n"), "space directions");
  for (const char* origin : {"1 2 3", "(1,2)", "none", "(1,2,nan)", "(1,2,3) (4,5,6)"})
    EXPECT_REFUSED(grid_of(lps + "space origin: " + origin + "\n"), "space origin");
}

}  // namespace
}  // namespace turgor::io
