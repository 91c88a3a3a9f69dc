#include "turgor/io/dicom/dicom.hpp"

#include "tests/io/dicom/dicom_series.hpp"
#include "turgor/geometry/hounsfield.hpp"

namespace turgor {
namespace {

using test::bytes_of;
using test::fresh_folder;
using test::make_ct;
using test::Series;
using test::set_value;
using test::write;

namespace fs = std::filesystem;

const Exec kExec(2);

// A CT with oblique axes and anisotropic spacing is read back with samples, grid and patient.
TEST(Dicom, ObliqueCtRoundTrips) {
  const Series s;
  double last = 0;
  const auto read = read_ct(kExec, s.path, {"", [&](double fraction) { last = std::max(last, fraction); }});
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
  EXPECT_EQ(read->ct.grid.size, s.ct.grid.size);
  EXPECT_LT(norm(point_at(read->ct.grid, {8, 6, 5}) - point_at(s.ct.grid, {8, 6, 5})), 1e-8);
  EXPECT_EQ(read->patient, "Test^Patient");
  EXPECT_EQ(read->files, 6);
  EXPECT_DOUBLE_EQ(last, 1);
}

// Writing the same volume twice gives the same bytes.
TEST(Dicom, WritingIsDeterministic) {
  const Series a, b;
  for (int number = 1; number <= 6; number++) EXPECT_EQ(bytes_of(a.slice(number)), bytes_of(b.slice(number)));
}

// One thread and eight threads read the same volume.
TEST(Dicom, ReadingIsIndependentOfThreadCount) {
  const Series s;
  const auto one = read_ct(Exec(1), s.path), eight = read_ct(Exec(8), s.path);
  ASSERT_TRUE(one && eight);
  EXPECT_EQ(one->ct.samples, eight->ct.samples);
  EXPECT_EQ(one->ct.grid, eight->ct.grid);
}

// The path of one slice reads the whole series of that slice.
TEST(Dicom, OneFileSelectsItsSeries) {
  const Series s;
  const Series other(4);
  fs::copy(other.slice(2), s.path / "other.dcm");
  const auto read = read_ct(kExec, s.slice(3));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
}

// A slice of another series than the requested one is refused.
TEST(Dicom, FileOfAnotherSeriesIsRefused) {
  const Series s;
  const Series other(4);
  fs::copy(other.slice(2), s.path / "other.dcm");
  const std::string own = io::read_dicom_header(s.slice(3)).slice->series,
                    foreign = io::read_dicom_header(other.slice(2)).slice->series;
  EXPECT_TRUE(read_ct(kExec, s.slice(3), {own, {}}));
  EXPECT_REFUSED(read_ct(kExec, s.slice(3), {foreign, {}}), own.c_str(), "name the folder instead");
}

// Numbers are whole words: a comma is no decimal point, and would make a spacing of 1.25 mm one of 1 mm.
TEST(Dicom, DecimalCommasAreRefused) {
  const Series s;
  s.set_every(0x28, 0x30, "1,25\\1,25");
  EXPECT_REFUSED(s.read(), "PixelSpacing");
}

// Slope and intercept scale the samples; a slope of NaN, zero or text is ignored.
TEST(Dicom, AppliesSlopeAndIntercept) {
  const Series s;
  s.set_every(0x28, 0x1053, "2");
  s.set_every(0x28, 0x1052, "-1024");
  auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples[5], 2 * s.ct.samples[5] - 1024);
  for (const char* slope : {"NaN", "0", "nonsense"}) {
    s.set_every(0x28, 0x1053, slope);
    read = s.read();
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->ct.samples, s.ct.samples) << slope;
  }
}

// Slices without a series identifier form one series.
TEST(Dicom, EmptySeriesIdsAreOneSeries) {
  const Series s;
  s.set_every(0x20, 0x0e, "");
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
}

// Several series in a folder are listed; one is selected by its number or UID.
TEST(Dicom, SeriesIsSelectedByNumberOrUid) {
  const Series s;
  ASSERT_TRUE(write_dicom(kExec, s.path / "second", make_ct(3), patient_alone("Test^Patient")));
  EXPECT_REFUSED(s.read(), "2 series", "--series", "6 slices of 9 x 7", "3 slices of 9 x 7", "Turgor volume",
                 "2.25.");
  EXPECT_EQ(s.read("1")->files + s.read("2")->files, 9);
  const std::string message = s.read().error().message,
                    uid = message.substr(message.find("2.25."),
                                         message.find('\n', message.find("2.25.")) - message.find("2.25."));
  EXPECT_EQ(s.read(uid)->files, s.read("1")->files);
  EXPECT_REFUSED(s.read("3"), "no series \"3\"", "2.25.");
}

// The error for missing slices states their count, the files beside the gap and its size.
TEST(Dicom, MissingSlicesAreLocated) {
  const Series s;
  fs::remove(s.slice(4));
  EXPECT_REFUSED(s.read(), "missing slices: 1", "slice-00003.dcm", "slice-00005.dcm", "2.50 mm", "1.25 mm");
  fs::remove(s.slice(3));
  EXPECT_REFUSED(s.read(), "missing slices: 2", "slice-00002.dcm", "slice-00005.dcm", "3.75 mm");
}

// Two slices at the same position are rejected.
TEST(Dicom, RejectsDuplicatePositions) {
  const Series s;
  fs::copy(s.slice(4), s.path / "again.dcm");
  EXPECT_REFUSED(s.read(), "same position", "slice-00004.dcm", "again.dcm");
}

// Slices at uneven distances are rejected.
TEST(Dicom, RejectsUnevenSpacing) {
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

// Gantry tilt is rejected; the error states the angle and the option that resamples it.
TEST(Dicom, RejectsGantryTilt) {
  const Series s;
  shear(s, 6, 0, 1.25 * std::tan(18.5 * M_PI / 180));
  EXPECT_REFUSED(s.read(), "gantry tilt of 18.5 degrees", "turgor import --straighten");
}

// Straightening slices that are shifted by whole pixels keeps every sample exactly.
TEST(Dicom, StraightensWholePixelShiftsExactly) {
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
TEST(Dicom, StraighteningReproducesLinearField) {
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
TEST(Dicom, StraighteningRejectsUnevenShear) {
  const Series s;
  shear(s, 6, 0, 0.42);
  const Vec3d p = point_at(s.ct.grid, {0, 0, 2}) * 1e3;
  set_value(s.slice(3), 0x20, 0x32,
            std::to_string(p.x) + "\\" + std::to_string(p.y) + "\\" + std::to_string(p.z));
  EXPECT_REFUSED(read_ct(kExec, s.path, {"", {}, true}), "slice-00003.dcm", "off the line");
}

// A slice with another orientation, size or pixel spacing is rejected and named.
TEST(Dicom, InconsistentSliceIsNamed) {
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
TEST(Dicom, LocalizersAreSkippedWithNote) {
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

// Images that are no CT, or that lack a valid position, orientation or spacing, are rejected.
TEST(Dicom, RejectsNonCtImages) {
  const struct {
    std::uint16_t group, element;
    const char* value;
    const char* word;
  } cases[] = {{0x08, 0x60, "MR", "Modality is \"MR\""},
               {0x28, 0x04, "RGB", "color"},
               {0x20, 0x32, "", "ImagePositionPatient"},
               {0x20, 0x32, "1\\2\\nan", "ImagePositionPatient"},
               {0x20, 0x37, "1\\0\\0\\1\\0\\0", "ImageOrientationPatient"},
               {0x28, 0x30, "0\\0", "PixelSpacing"}};
  for (const auto& c : cases) {
    const Series s;
    s.set_every(c.group, c.element, c.value);
    EXPECT_REFUSED(s.read(), c.word, "slice-0000");
  }
}

// A truncated slice is rejected and named.
TEST(Dicom, TruncatedSliceIsNamed) {
  const Series s;
  const std::string whole = bytes_of(s.slice(2));
  for (const std::size_t kept : {whole.size() - 1, whole.size() - 100, std::size_t{400}, std::size_t{200}}) {
    write(s.slice(2), whole.substr(0, kept));
    EXPECT_REFUSED(s.read(), "slice-00002.dcm", "truncated");
  }
}

const fs::path kCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "ct";

// Every transfer syntax gives the same samples.
TEST(Dicom, TransferSyntaxesGiveSameSamples) {
  const std::filesystem::path folder = fresh_folder();
  std::vector<std::int16_t> first;
  for (const char* name : {"explicit.dcm", "implicit.dcm", "rle.dcm", "jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    fs::create_directory(folder / name);
    fs::copy(kCorpus / name, folder / name);
    const auto read = read_ct(kExec, folder / name);
    ASSERT_TRUE(read) << read.error().message;
    if (first.empty()) first = read->ct.samples;
    ASSERT_EQ(read->ct.samples.size(), 256u);
    EXPECT_EQ(read->ct.samples, first) << name;
  }
}

// A damaged or truncated compressed image gives an error message.
TEST(Dicom, RejectsDamagedCompressedImage) {
  for (const char* name : {"rle.dcm", "jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    const std::filesystem::path folder = fresh_folder();
    std::string bytes = bytes_of(kCorpus / name);
    const std::size_t pixels = bytes.find(std::string("\xe0\x7f\x10\0", 4), 132);
    ASSERT_NE(pixels, std::string::npos);
    for (std::size_t at = pixels + 28; at < pixels + 60; at++)
      bytes[at] = char(0xa5);  // head of the compressed stream
    write(folder / name, bytes);
    EXPECT_REFUSED(read_ct(kExec, folder / name), name, "decoded");
    write(folder / name, bytes.substr(0, bytes.size() - 20));
    EXPECT_REFUSED(read_ct(kExec, folder / name), name, "truncated");
  }
}

// Samples with the padding value become air.
TEST(Dicom, PaddingBecomesAir) {
  const Series s;
  // PixelPaddingValue follows PixelRepresentation (0028,0103), the last element of its group below
  // (0028,1050).
  const std::int16_t pad = s.ct.samples[4];
  for (int number = 1; number <= 6; number++) {
    std::string bytes = bytes_of(s.slice(number));
    const std::size_t at = bytes.find(std::string("\x28\0\x03\x01US", 6), 132);
    ASSERT_NE(at, std::string::npos);
    bytes.insert(at + 10, std::string("\x28\0\x20\x01SS\x02\0", 8) + char(pad & 255) + char(pad >> 8));
    write(s.slice(number), bytes);
  }
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  for (std::size_t n = 0; n < s.ct.samples.size(); n++)
    EXPECT_EQ(read->ct.samples[n], s.ct.samples[n] == pad ? kAirHu : s.ct.samples[n]);
}

// Notes count the samples that became air and those that were clamped.
TEST(Dicom, PaddingAndClampingAreCounted) {
  const Series s;
  for (int number = 1; number <= 6; number++) {
    std::string bytes = bytes_of(s.slice(number));
    const std::size_t at = bytes.find(std::string("\x28\0\x03\x01US", 6), 132);
    const std::int16_t low = -2000, high = -1500;
    const auto element = [](char low_byte, std::int16_t value) {
      return std::string("\x28\0", 2) + low_byte + std::string("\x01SS\x02\0", 5) + char(value & 255) +
             char(value >> 8);
    };
    bytes.insert(at + 10, element('\x20', low) + element('\x21', high));
    write(s.slice(number), bytes);
  }
  const auto padded = std::count_if(s.ct.samples.begin(), s.ct.samples.end(),
                                    [](int hu) { return hu >= -2000 && hu <= -1500; });
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_TRUE(read->notes[0].starts_with(std::to_string(padded) + " samples became air (-1000 HU)"))
      << read->notes[0];
  s.set_every(0x28, 0x1053, "20");
  const auto clamped =
      std::count_if(s.ct.samples.begin(), s.ct.samples.end(), [](int hu) { return hu > 1638 || hu < -2000; });
  const auto scaled = s.read();
  ASSERT_TRUE(scaled) << scaled.error().message;
  ASSERT_EQ(scaled->notes.size(), 3u);  // the third note reports implausible Hounsfield units
  EXPECT_TRUE(scaled->notes[1].starts_with(std::to_string(clamped) +
                                           " samples outside -32768 to 32767 HU were clamped"))
      << scaled->notes[1];
}

// A note reports rounding if the slope is not a whole number.
TEST(Dicom, FractionalSlopeIsNoted) {
  const Series s;
  s.set_every(0x28, 0x1053, "0.5");
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_NE(read->notes[0].find("rounded to integer Hounsfield units: RescaleSlope 0.5"), std::string::npos)
      << read->notes[0];
}

// Samples that do not start at the lowest bit are rejected.
TEST(Dicom, RejectsShiftedHighBit) {
  const Series s;
  s.set_every(0x28, 0x101, std::string("\x0c\0", 2));  // 12 bits, from bit 15 downwards
  EXPECT_REFUSED(s.read(), "HighBit (0028,0102) is 15 with 12 bits stored", "expected 11");
}

// Compressed pixels whose size contradicts the header are rejected before they are decoded.
TEST(Dicom, ChecksCompressedSizeBeforeDecoding) {
  for (const char* name : {"jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    const fs::path file = fresh_folder() / name;
    fs::copy(kCorpus / name, file);
    set_value(file, 0x28, 0x10, std::string("\x0f\0", 2));
    EXPECT_REFUSED(read_ct(kExec, file), name, "16 x 15", "compressed pixels 16 x 16");
    set_value(file, 0x28, 0x10, std::string("\x30\x75", 2));
    set_value(file, 0x28, 0x11, std::string("\x30\x75", 2));
    EXPECT_REFUSED(read_ct(kExec, file), name, "30000 x 30000 pixels", "at most 67108864");
  }
}

// A folder without DICOM images is rejected.
TEST(Dicom, RejectsFolderWithoutImages) {
  const std::filesystem::path folder = fresh_folder();
  write(folder / "notes.txt", "nothing to see");
  EXPECT_REFUSED(read_ct(kExec, folder / ""), "no DICOM images among 1 files");
}

// Other files beside the slices do not disturb reading.
TEST(Dicom, IgnoresOtherFiles) {
  const Series s;
  write(s.path / "README.txt", "a CT");
  write(s.path / "DICOMDIR", "");
  EXPECT_TRUE(s.read());
}

// A series is written only into a new or empty folder.
TEST(Dicom, WritesOnlyIntoEmptyFolder) {
  const Series s;
  EXPECT_REFUSED(write_dicom(kExec, s.path, s.ct, {}), "not an empty folder");
  fs::create_directory(s.folder / "empty");
  EXPECT_TRUE(write_dicom(kExec, s.folder / "empty", s.ct, {}));
  EXPECT_REFUSED(write_dicom(kExec, s.folder / "a" / "b", s.ct, {}), "does not exist");
  EXPECT_FALSE(fs::exists(s.folder / "a"));
}

}  // namespace
}  // namespace turgor
