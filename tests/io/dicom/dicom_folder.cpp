// Other contents of a series' folder: damaged slices and unrelated files.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/io/dicom/dicom_series.hpp"

namespace turgor {
namespace {

using test::bytes_of;
using test::make_ct;
using test::Series;
using test::set_value;
using test::write;

namespace fs = std::filesystem;

bool notes_say(const CtFile& file, const std::string& words) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

/// Truncates the file before the element.
void cut_before(const fs::path& file, std::uint16_t group, std::uint16_t element) {
  const std::string bytes = bytes_of(file);
  const std::string tag{char(group & 255), char(group >> 8), char(element & 255), char(element >> 8)};
  write(file, bytes.substr(0, bytes.find(tag, 132)));
}

// A first or last slice that is empty, truncated or no DICOM file is rejected and named.
TEST(DicomFolder, DamagedEndSliceIsNamed) {
  for (const int number : {1, 6}) {
    const Series s;
    const fs::path file = s.slice(number);
    const std::string name = file.filename().string(), whole = bytes_of(file);
    for (const std::size_t kept : {std::size_t{0}, std::size_t{100}, std::size_t{131}, whole.size() - 1}) {
      write(file, whole.substr(0, kept));
      EXPECT_REFUSED(s.read(), name.c_str(), "expected a slice of the series");
    }
    write(file, "<html>404 not found</html>");
    EXPECT_REFUSED(s.read(), name.c_str(), "is not a DICOM file");
    for (const std::uint16_t element : {0x10, 0x11}) {  // Rows, Columns: the elements before them are intact
      write(file, whole);
      cut_before(file, 0x28, element);
      EXPECT_REFUSED(s.read(), name.c_str(), "truncated", "Rows");
    }
    write(file, whole);
    cut_before(file, 0x08, 0x16);  // only the meta header of the file remains
    EXPECT_REFUSED(s.read(), name.c_str(), "truncated");
    EXPECT_REFUSED(read_ct(Exec(2), s.slice(3)), name.c_str());
  }
}

// A broken link instead of a slice is rejected and named.
TEST(DicomFolder, BrokenLinkIsNamed) {
  const Series s;
  fs::remove(s.slice(6));
  fs::create_symlink("../annex/elsewhere.dcm", s.slice(6));
  EXPECT_REFUSED(s.read(), "slice-00006.dcm", "link to a file that does not exist");
}

// A damaged file prevents reading of its own series only.
TEST(DicomFolder, DamagedFileBlocksOnlyItsSeries) {
  const Series s;
  ASSERT_TRUE(write_dicom(Exec(2), s.path / "second", make_ct(3), patient_alone("Test^Patient")));
  const fs::path file = s.path / "second" / "slice-00003.dcm";
  const std::string whole = bytes_of(file);
  write(file, whole.substr(0, whole.size() - 10));
  EXPECT_REFUSED(s.read(), "2 series");
  const auto first = s.read("2");  // sorted by the names of their files
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->files, 6);
  EXPECT_TRUE(notes_say(*first, "slice-00003.dcm")) << "the note names the file";
  EXPECT_TRUE(notes_say(*first, "of another series"));
  EXPECT_REFUSED(s.read("1"), "second/slice-00003.dcm", "truncated");
}

// A damaged file that may belong to either of two series is named in a note.
TEST(DicomFolder, UnassignableFileIsNoted) {
  const Series s;
  ASSERT_TRUE(write_dicom(Exec(2), s.folder / "second", make_ct(3), patient_alone("Test^Patient")));
  for (const auto& entry : fs::directory_iterator(s.folder / "second"))
    fs::rename(entry.path(), s.path / ("1" + entry.path().filename().string()));
  write(s.path / "lost.dcm", "");
  const auto read = s.read("2");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(notes_say(*read, "lost.dcm: is empty"));
}

// Files that are not images of a CT are skipped with a note.
TEST(DicomFolder, ForeignFilesAreSkippedWithNote) {
  const Series s;
  for (const char* name : {"README.txt", "DICOMDIR", "photo.jpg", ".DS_Store", "._slice-00001.dcm"})
    write(s.path / name, "something else");
  fs::copy(s.slice(1), s.path / "dose.dcm");  // a report: another SOP class, no pixels
  set_value(s.path / "dose.dcm", 0x08, 0x16, "1.2.840.10008.5.1.4.1.1.88.67");
  cut_before(s.path / "dose.dcm", 0x28, 0x10);
  ASSERT_EQ(mkfifo((s.path / "pipe").c_str(), 0600), 0);
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
  EXPECT_TRUE(notes_say(*read, "skipped 6 files that are not an image of a CT")) << read->notes[0];
  EXPECT_TRUE(notes_say(*read, "README.txt"));
}

// A file whose byte order contradicts its transfer syntax is rejected.
TEST(DicomFolder, RejectsWrongByteOrder) {
  const Series s(1);
  std::string bytes = bytes_of(s.slice(1));
  const std::size_t at = bytes.find("1.2.840.10008.1.2.1");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 18] = '2';  // claims big endian, but the data is little endian
  write(s.slice(1), bytes);
  EXPECT_REFUSED(s.read(), "slice-00001.dcm", "corrupt");
  EXPECT_REFUSED(read_ct(Exec(2), s.slice(1)), "corrupt");
}

// Only the header of a huge file of another series is read.
TEST(DicomFolder, HugeFileIsNotLoaded) {
  const Series s;
  fs::copy(s.slice(1), s.path / "huge.dcm");
  set_value(s.path / "huge.dcm", 0x20, 0x0e, "1.2.3");
  std::string bytes = bytes_of(s.path / "huge.dcm");
  const std::size_t syntax = bytes.find("1.2.840.10008.1.2.1");
  bytes.replace(
      syntax, 20,
      std::string("1.2.840.10008.1.2.5\0", 20));  // claims compression, but the pixels are not compressed
  write(s.path / "huge.dcm", bytes);
  fs::resize_file(s.path / "huge.dcm", std::uintmax_t{1} << 40);  // sparse
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, s.ct.samples);
  EXPECT_TRUE(notes_say(*read, "huge.dcm"));
}

// A file without read permission is not reported as missing.
TEST(DicomFolder, PermissionErrorIsDistinct) {
  if (geteuid() == 0 && seteuid(65534) != 0) GTEST_SKIP() << "cannot become a user without permissions";
  const fs::path folder = test::fresh_folder();
  write(folder / "a.nii", "x");
  fs::permissions(folder / "a.nii", fs::perms::none);
  fs::create_directory(folder / "closed");
  fs::permissions(folder / "closed", fs::perms::none);
  EXPECT_REFUSED(read_ct(Exec(2), folder / "a.nii"), "permission denied");
  EXPECT_REFUSED(read_ct(Exec(2), folder / "closed"), "permission denied");
  EXPECT_REFUSED(read_labels(folder / "closed" / "b.nii"), "permission denied");
  fs::permissions(folder / "closed", fs::perms::owner_all);
  ASSERT_TRUE(getuid() != 0 || seteuid(0) == 0);
}

}  // namespace
}  // namespace turgor
