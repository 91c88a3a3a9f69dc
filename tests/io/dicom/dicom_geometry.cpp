// Positions of slices: gaps, gantry tilt, inconsistent slices.
#include "tests/io/dicom/dicom_series.hpp"
#include "turgor/geometry/hounsfield.hpp"

namespace turgor {
namespace {

using test::Series;
using test::set_value;

namespace fs = std::filesystem;

const Exec kExec(2);

// The error for missing slices states their count, the files beside the gap and its size.
TEST(DicomGeometry, MissingSlicesAreLocated) {
  const Series s;
  fs::remove(s.slice(4));
  EXPECT_REFUSED(s.read(), "missing slices: 1", "slice-00003.dcm", "slice-00005.dcm", "2.50 mm", "1.25 mm");
  fs::remove(s.slice(3));
  EXPECT_REFUSED(s.read(), "missing slices: 2", "slice-00002.dcm", "slice-00005.dcm", "3.75 mm");
}

// Two slices at the same position are rejected.
TEST(DicomGeometry, RejectsDuplicatePositions) {
  const Series s;
  fs::copy(s.slice(4), s.path / "again.dcm");
  EXPECT_REFUSED(s.read(), "same position", "slice-00004.dcm", "again.dcm");
}

// Slices at uneven distances are rejected.
TEST(DicomGeometry, RejectsUnevenSpacing) {
  const Series s;
  const Vec3d moved = point_at(s.ct.grid, {0, 0, 2.4}) * 1e3;
  set_value(s.slice(3), 0x20, 0x32,
            std::to_string(moved.x) + "\\" + std::to_string(moved.y) + "\\" + std::to_string(moved.z));
  EXPECT_REFUSED(s.read(), "uneven slice distance", "slice-00003.dcm", "1.25 mm");
}

/// Shifts every slice in its plane by the given millimeters per slice, along its rows and columns.
void shear(const Series& s, int slices, double along_rows, double along_columns) {
  for (int number = 1; number <= slices; number++) {
    const Mat3d& axes = s.ct.grid.axes;
    const Vec3d p = point_at(s.ct.grid, {0, 0, number - 1.0}) * 1e3 +
                    (axes.column[0] * along_rows + axes.column[1] * along_columns) * (number - 1);
    set_value(s.slice(number), 0x20, 0x32,
              std::to_string(p.x) + "\\" + std::to_string(p.y) + "\\" + std::to_string(p.z));
  }
}

// Gantry tilt is rejected; the error states the angle, the slice that is farthest from the first, its
// distance, and the option that resamples it.
TEST(DicomGeometry, RejectsGantryTilt) {
  const Series s;
  shear(s, 6, 0, 1.25 * std::tan(18.5 * M_PI / 180));
  EXPECT_REFUSED(s.read(), "gantry tilt of 18.5 degrees",
                 "slice-00006.dcm is shifted in its plane by 2.09 mm", "from slice-00001.dcm",
                 "turgor import --straighten");
}

// A slice that is shifted alone is named; it is no gantry tilt.
TEST(DicomGeometry, ShiftedSliceIsNamed) {
  const Series s;
  const Vec3d p = (point_at(s.ct.grid, {0, 0, 3}) + s.ct.grid.axes.column[1] * 1.5e-3) * 1e3;
  set_value(s.slice(4), 0x20, 0x32,
            std::to_string(p.x) + "\\" + std::to_string(p.y) + "\\" + std::to_string(p.z));
  EXPECT_REFUSED(s.read(),
                 "ct: slice slice-00004.dcm is shifted in its plane by 1.50 mm from slice-00001.dcm",
                 "expected a straight stack");
  EXPECT_EQ(s.read().error().message.find("tilt"), std::string::npos);
  EXPECT_EQ(s.read().error().message.find("--straighten"), std::string::npos) << "it refuses the slice, too";
}

// Straightening slices that are shifted by whole pixels keeps every sample exactly.
TEST(DicomGeometry, StraightensWholePixelShiftsExactly) {
  for (const int down : {1, -2}) {
    const Series s;
    shear(s, 6, -0.75, 0.5 * down);  // one pixel to the right and `down` pixels
    const auto read = read_ct(kExec, s.path, {"", {}, true});
    ASSERT_TRUE(read) << read.error().message;
    const Grid& grid = read->ct.grid;
    EXPECT_EQ(grid.size, (Int3{9 + 5, 7 + 5 * std::abs(down), 6}));
    const Vec3d first = index_at(grid, s.ct.grid.origin);  // index of the origin of the first slice
    for (int k = 0; k < 6; k++)
      for (int j = 0; j < 7; j++)
        for (int i = 0; i < 9; i++)
          ASSERT_EQ(
              read->ct.at(int(std::lround(first.x)) + i - k, int(std::lround(first.y)) + j + down * k, k),
              s.ct.at(i, j, k));
    EXPECT_EQ(std::count(read->ct.samples.begin(), read->ct.samples.end(), kAirHu),
              long(sample_count(grid)) - 9 * 7 * 6);
    ASSERT_FALSE(read->notes.empty());
    EXPECT_NE(read->notes[0].find("gantry tilt of"), std::string::npos);
  }
}

// A field that is linear in space survives straightening of any tilt.
TEST(DicomGeometry, StraighteningReproducesLinearField) {
  Series s;
  const Vec3d slope{31, -47, 23};  // HU per millimeter, along the CT's axes
  for (int k = 0; k < 6; k++)
    for (int j = 0; j < 7; j++)
      for (int i = 0; i < 9; i++)  // at the positions of the sheared slices
        s.ct.at(i, j, k) = std::int16_t(std::lround(slope.x * (0.75 * i + 0.31 * k) +
                                                    slope.y * (0.5 * j + 0.43 * k) + slope.z * 1.25 * k));
  fs::remove_all(s.path);
  ASSERT_TRUE(write_dicom(kExec, s.path, s.ct, patient_alone("Test^Patient")));
  shear(s, 6, 0.31, 0.43);
  const auto read = read_ct(kExec, s.path, {"", {}, true});
  ASSERT_TRUE(read) << read.error().message;
  int inside = 0;
  for (int k = 0; k < 6; k++)
    for (int j = 0; j < read->ct.grid.size.y; j++)
      for (int i = 0; i < read->ct.grid.size.x; i++) {
        const Vec3d p = index_at(s.ct.grid, point_at(read->ct.grid, {double(i), double(j), double(k)}));
        const double x = 0.75 * p.x, y = 0.5 * p.y, own_x = x - 0.31 * k, own_y = y - 0.43 * k;
        if (own_x < 0 || own_y < 0 || own_x > 0.75 * 8 || own_y > 0.5 * 6) continue;
        EXPECT_NEAR(read->ct.at(i, j, k), slope.x * x + slope.y * y + slope.z * 1.25 * k, 1.5);
        inside++;
      }
  EXPECT_GT(inside, 250);
}

// Straightening rejects slices whose origins do not lie on one line.
TEST(DicomGeometry, StraighteningRejectsUnevenShear) {
  const Series s;
  shear(s, 6, 0, 0.42);
  const Vec3d p = point_at(s.ct.grid, {0, 0, 2}) * 1e3;
  set_value(s.slice(3), 0x20, 0x32,
            std::to_string(p.x) + "\\" + std::to_string(p.y) + "\\" + std::to_string(p.z));
  EXPECT_REFUSED(read_ct(kExec, s.path, {"", {}, true}), "slice-00003.dcm", "off the line");
}

// A slice with another orientation, size or pixel spacing is rejected and named.
TEST(DicomGeometry, InconsistentSliceIsNamed) {
  {
    const Series s;
    set_value(s.slice(5), 0x20, 0x37, "1\\0\\0\\0\\1\\0");
    EXPECT_REFUSED(s.read(), "slice-00005.dcm", "orientation");
  }
  {
    const Series s;
    set_value(s.slice(5), 0x28, 0x10, std::string("\x05\0", 2));
    EXPECT_REFUSED(s.read(), "slice-00005.dcm", "9 x 5");
  }
  {
    const Series s;
    set_value(s.slice(5), 0x28, 0x30, "0.6\\0.75");
    EXPECT_REFUSED(s.read(), "slice-00005.dcm", "0.6 mm");
  }
}

// Localizers of the series are skipped with a note.
TEST(DicomGeometry, LocalizersAreSkippedWithNote) {
  const Series s;
  fs::copy(s.slice(1), s.path / "scout.dcm");
  set_value(s.path / "scout.dcm", 0x20, 0x37, "1\\0\\0\\0\\0\\-1");
  set_value(s.path / "scout.dcm", 0x08, 0x08, "ORIGINAL\\PRIMARY\\LOCALIZER");
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_NE(read->notes[0].find("1 localizer"), std::string::npos);
}

}  // namespace
}  // namespace turgor
