#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {
namespace {

/// Grid of 2 x 2 x 2 bytes with these fields.
Result<Grid> grid_of(const std::string& fields) {
  const auto file = test::fresh_folder() / "a.mha";
  test::write(file,
              "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\n" +
                  fields + "ElementDataFile = LOCAL\n12345678");
  const auto raw = read_volume_file(file);
  if (!raw) return raw.error();
  return raw->grid;
}

// Origin and axes of the grid are read from any of three field names each.
TEST(MetaHeader, OriginAndAxesHaveThreeNames) {
  for (const std::string origin : {"Offset", "Position", "Origin"})
    for (const std::string axes : {"TransformMatrix", "Rotation", "Orientation"}) {
      const auto grid = grid_of("ElementSpacing = 0.5 2 3\n" + origin + " = 1 -2 3e1\n" + axes +
                                " = 0.6 0.8 0 -0.8 0.6 0 0 0 1\nCenterOfRotation = 7 8 9\n"
                                "AnatomicalOrientation = RAI\n");
      ASSERT_TRUE(grid) << grid.error().message;
      EXPECT_LT(norm(point_at(*grid, {}) - Vec3d{0.001, -0.002, 0.030}), 1e-12);
      EXPECT_LT(norm(point_at(*grid, {1, 0, 0}) - point_at(*grid, {}) - Vec3d{0.0003, 0.0004, 0}), 1e-12);
      EXPECT_LT(norm(point_at(*grid, {0, 1, 0}) - point_at(*grid, {}) - Vec3d{-0.0016, 0.0012, 0}), 1e-12);
      EXPECT_LT(norm(point_at(*grid, {0, 0, 1}) - point_at(*grid, {}) - Vec3d{0, 0, 0.003}), 1e-12);
    }
}

// ElementSize is the spacing if ElementSpacing is missing.
TEST(MetaHeader, SpacingFallsBackToElementSize) {
  EXPECT_EQ(grid_of("ElementSize = 2 3 4\n")->spacing, (Vec3d{2e-3, 3e-3, 4e-3}));
  EXPECT_EQ(grid_of("ElementSize = 2 3 4\nElementSpacing = 5 6 7\n")->spacing, (Vec3d{5e-3, 6e-3, 7e-3}));
  EXPECT_EQ(grid_of("")->spacing, (Vec3d{1e-3, 1e-3, 1e-3}));
}

// Contradictory fields, units other than millimeters and scaled axes are rejected.
TEST(MetaHeader, RejectsContradictionsAndUnits) {
  EXPECT_REFUSED(grid_of("Offset = 1 2 3\nOrigin = 4 5 6\n"), "Origin = 4 5 6", "contradicts",
                 "Offset = 1 2 3");
  EXPECT_TRUE(grid_of("Offset = 1 2 3\nOrigin = 1 2 3\n"));
  EXPECT_REFUSED(grid_of("DistanceUnits = cm\n"), "DistanceUnits = cm", "expected mm");
  EXPECT_TRUE(grid_of("DistanceUnits = mm\n"));
  EXPECT_REFUSED(grid_of("TransformMatrix = 2 0 0 0 2 0 0 0 2\n"), "length 2", "expected 1");
  EXPECT_REFUSED(grid_of("TransformMatrix = 1 0 0 0 1 0\n"), "TransformMatrix", "9 finite numbers");
  EXPECT_REFUSED(grid_of("Offset = 1 nan 3\n"), "Offset", "3 finite numbers");
}

}  // namespace
}  // namespace turgor::io
