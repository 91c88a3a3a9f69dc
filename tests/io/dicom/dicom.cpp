#include "turgor/io/dicom/dicom.hpp"

#include "tests/io/dicom/dicom_series.hpp"

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
