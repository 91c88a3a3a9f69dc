// NIfTI files byte by byte: types, scaling, grids, extensions with the names of labels.
#include <cmath>
#include <cstring>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/ct.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;
using test::write;

/// A NIfTI-1 file of 3 x 2 x 2 samples in native byte order, whose grid is given by the spacing only.
struct Nifti {
  std::string bytes = std::string(352, '\0');

  template <class T>
  void put(std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }
  template <class T>
  Nifti(std::int16_t type, std::initializer_list<T> samples,
        std::array<std::int16_t, 8> dim = {3, 3, 2, 2, 1, 1, 1, 1}) {
    put<std::int32_t>(0, 348);
    for (std::size_t axis = 0; axis < 8; axis++) put(40 + 2 * axis, dim[axis]);
    put<std::int16_t>(70, type);
    put<std::int16_t>(72, sizeof(T) * 8);
    for (std::size_t axis = 0; axis < 8; axis++) put<float>(76 + 4 * axis, 1);
    put<float>(108, 352);
    put<float>(112, 1);
    std::memcpy(bytes.data() + 344, "n+1", 4);
    for (const T sample : samples) bytes.append(reinterpret_cast<const char*>(&sample), sizeof sample);
  }
};

Nifti int32_file() { return Nifti(8, {-1000, 0, 60, 3000, 5, 6, 7, 8, 9, 10, 11, 12}); }

Result<CtFile> read_bytes(const std::string& bytes) {
  const std::filesystem::path folder = fresh_folder();
  write(folder / "a.nii", bytes);
  return read_ct(Exec(1), folder / "a.nii");
}

// Files that state no orientation or spacing are read with a note.
TEST(VolumeFile, MissingSpacingOrOrientationIsNoted) {
  const auto notes = [](const char* name, const std::string& bytes) {
    const std::filesystem::path folder = fresh_folder();
    write(folder / name, bytes);
    const Result<CtFile> read = read_ct(Exec(1), folder / name);
    EXPECT_TRUE(read) << read.error().message;
    std::string all;
    for (const std::string& note : read ? read->notes : std::vector<std::string>{}) all += note + "\n";
    return all;
  };
  const std::string samples(24, '\0');
  EXPECT_NE(notes("a.nii", int32_file().bytes).find("states no orientation"), std::string::npos);
  EXPECT_NE(
      notes("a.nrrd",
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nencoding: raw\nendian: little\n\n" + samples)
          .find("states no spacing"),
      std::string::npos);
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementType = MET_SHORT\nBinaryData = True\n";
  const std::string data = "ElementDataFile = LOCAL\n" + samples;
  EXPECT_NE(notes("a.mha", meta + data).find("states no spacing"), std::string::npos);
  EXPECT_EQ(notes("a.mha", meta + "ElementSpacing = 1 1 2\n" + data).find("states no"), std::string::npos);
}

// Options of DICOM are refused for other formats.
TEST(VolumeFile, SeriesAndTiltAreOfDicomOnly) {
  const std::filesystem::path folder = fresh_folder();
  write(folder / "a.nii", int32_file().bytes);
  EXPECT_REFUSED(read_ct(Exec(1), folder / "a.nii", {"2", {}}), "only DICOM");
  EXPECT_REFUSED(read_ct(Exec(1), folder / "a.nii", {"", {}, true}), "only DICOM");
}

// A slope of NaN or zero means no scaling.
TEST(NiftiFile, InvalidSlopeMeansNoScaling) {
  for (const float slope : {std::nanf(""), 0.0f, 1.0f}) {
    Nifti file = int32_file();
    file.put<float>(112, slope);
    file.put<float>(116, slope == 1 ? 0 : slope);
    const auto read = read_bytes(file.bytes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->ct.samples[0], -1000) << slope;
    EXPECT_EQ(read->ct.samples[3], 3000) << slope;
  }
}

// Slope and intercept scale the samples.
TEST(NiftiFile, AppliesSlopeAndIntercept) {
  Nifti file = int32_file();
  file.put<float>(112, 0.5f);
  file.put<float>(116, -1024);
  const auto read = read_bytes(file.bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples[2], -994);
  EXPECT_EQ(read->ct.samples[3], 476);
}

// Values are rounded and clamped to 16 bits; NaN becomes air.
TEST(NiftiFile, ValuesAreRoundedAndClamped) {
  const auto read = read_bytes(
      Nifti(16, {1e9f, -1e9f, 0.6f, -0.6f, std::nanf(""), 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f}).bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples[0], 32767);
  EXPECT_EQ(read->ct.samples[1], -32768);
  EXPECT_EQ(read->ct.samples[2], 1);
  EXPECT_EQ(read->ct.samples[3], -1);
  EXPECT_EQ(read->ct.samples[4], kAirHu);
}

bool has_note(const Result<CtFile>& read, const std::string& words) {
  return std::any_of(read->notes.begin(), read->notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

// Notes count the samples that were rounded, clamped or not a number.
TEST(NiftiFile, RoundingIsNoted) {
  const float nan = std::nanf("");
  const auto read =
      read_bytes(Nifti(16, {1e9f, 0.5f, -0.25f, nan, 7.f, 8.f, 9.f, 1.f, 2.f, 3.f, 4.f, -1e9f}).bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(has_note(read, "2 of 12 samples were rounded to integer Hounsfield units"));
  EXPECT_TRUE(has_note(read, "1 of 12 samples are not numbers (NaN) and became air (-1000 HU)"));
  EXPECT_TRUE(has_note(read, "2 of 12 samples were outside -32768 to 32767 HU"));
  const auto whole =
      read_bytes(Nifti(16, {-1000.f, 0.f, 40.f, 3.f, 7.f, 8.f, 9.f, 1.f, 2.f, 3.f, 4.f, 5.f}).bytes);
  ASSERT_TRUE(whole) << whole.error().message;
  ASSERT_EQ(whole->notes.size(), 1u);  // the file has no orientation
  EXPECT_TRUE(has_note(whole, "states no orientation"));
}

// A note reports values that do not look like Hounsfield units.
TEST(NiftiFile, ImplausibleHounsfieldUnitsAreNoted) {
  const auto read =
      read_bytes(Nifti(2, std::initializer_list<std::uint8_t>{0, 9, 99, 255, 5, 6, 7, 8, 9, 1, 2, 3}).bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(has_note(read, "do not look like Hounsfield units"));
  EXPECT_TRUE(has_note(read, "from 0 to 255"));
}

// A file in the other byte order is read.
TEST(NiftiFile, ReadsSwappedByteOrder) {
  std::string bytes = int32_file().bytes;
  const auto swap = [&](std::size_t at, std::size_t size) {
    std::reverse(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + size));
  };
  swap(0, 4);
  for (std::size_t at = 40; at < 56; at += 2) swap(at, 2);
  for (const std::size_t at : {68, 70, 72, 74, 252, 254}) swap(at, 2);
  for (std::size_t at = 76; at < 120; at += 4) swap(at, 4);
  for (std::size_t at = 352; at < bytes.size(); at += 4) swap(at, 4);
  const auto read = read_bytes(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples[0], -1000);
  EXPECT_EQ(read->ct.samples[11], 12);
}

// The sform determines the grid if sform and qform exist.
TEST(NiftiFile, SformHasPriority) {
  Nifti file = int32_file();
  file.put<std::int16_t>(252, 1);
  file.put<std::int16_t>(254, 2);
  const float rows[3][4] = {
      {0, 0, 2, 10}, {3, 0, 0, 20}, {0, 4, 0, 30}};  // i to the front, j to the head, k to the right
  for (std::size_t row = 0; row < 3; row++)
    for (std::size_t column = 0; column < 4; column++)
      file.put(280 + 16 * row + 4 * column, rows[row][column]);
  const auto read = read_bytes(file.bytes);
  ASSERT_TRUE(read) << read.error().message;
  const Vec3d first = point_at(read->ct.grid, {}), last = point_at(read->ct.grid, {2, 1, 1});
  EXPECT_NEAR(norm(first - Vec3d{-0.010, -0.020, 0.030}), 0, 1e-9);
  EXPECT_NEAR(norm(last - Vec3d{-0.012, -0.026, 0.034}), 0, 1e-9);
}

// A corrupt header is rejected before memory is allocated.
TEST(NiftiFile, RejectsCorruptHeader) {
  const auto refused = [](const char* word, auto change) {
    Nifti file = int32_file();
    change(file);
    EXPECT_REFUSED(read_bytes(file.bytes), word);
  };
  refused("truncated", [](Nifti& f) { f.put<std::int16_t>(42, 30000), f.put<std::int16_t>(44, 30000); });
  refused("2^33", [](Nifti& f) {
    for (std::size_t a : {42, 44, 46}) f.put<std::int16_t>(a, 32767);
  });
  refused("samples", [](Nifti& f) { f.put<std::int16_t>(42, -3); });
  refused("dimension 4", [](Nifti& f) { f.put<std::int16_t>(40, 4), f.put<std::int16_t>(48, 2); });
  refused("dimensions", [](Nifti& f) { f.put<std::int16_t>(40, 9); });
  refused("spacing", [](Nifti& f) { f.put<float>(84, 0); });
  refused("spacing", [](Nifti& f) { f.put<float>(84, std::nanf("")); });
  refused("type", [](Nifti& f) { f.put<std::int16_t>(70, 1792); });
  refused("bits", [](Nifti& f) { f.put<std::int16_t>(72, 8); });
  refused("byte", [](Nifti& f) { f.put<float>(108, 1e30f); });
  refused("two-file", [](Nifti& f) { std::memcpy(f.bytes.data() + 344, "ni1", 4); });
  refused("NIfTI header has 544", [](Nifti& f) { f.put<std::int32_t>(0, 540); });
}

// Sheared axes are rejected in NIfTI and NRRD files.
TEST(NiftiFile, RejectsShearedAxes) {
  Nifti file = int32_file();
  file.put<std::int16_t>(254, 2);
  const float rows[3][4] = {{1, 0.4f, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  for (std::size_t row = 0; row < 3; row++)
    for (std::size_t column = 0; column < 4; column++)
      file.put(280 + 16 * row + 4 * column, rows[row][column]);
  EXPECT_FALSE(read_bytes(file.bytes));
  const std::filesystem::path folder = fresh_folder();
  write(folder / "a.nrrd",
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\nspace "
        "directions: (1,0,0) (0.5,1,0) "
        "(0,0,1)\nendian: little\nencoding: raw\nspace origin: (0,0,0)\n\n" +
            std::string(16, '\0'));
  EXPECT_REFUSED(read_ct(Exec(1), folder / "a.nrrd"), "degrees", "orthogonal axes");
}

/// Labels 0, 1, 2 with an extension between header and samples.
std::string nifti_with(int kind, std::string text) {
  Nifti file(2, std::initializer_list<std::uint8_t>{0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2});
  text.resize((text.size() + 8 + 15) / 16 * 16 - 8, '\0');
  std::string extension(8, '\0');
  const auto size = std::int32_t(text.size() + 8), code = std::int32_t(kind);
  std::memcpy(extension.data(), &size, 4);
  std::memcpy(extension.data() + 4, &code, 4);
  file.put<float>(108, 352 + float(size));
  file.bytes[348] = 1;
  file.bytes.insert(352, extension + text);
  return file.bytes;
}

// A header extension in XML, JSON or Python syntax gives the names of labels.
TEST(NiftiFile, ExtensionNamesLabels) {
  const char* xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?><CaretExtension><VolumeInformation Index=\"0\"><LabelTable>"
      "<Label Key=\"1\" Red=\"0.2\" Green=\"0.3\" Blue=\"0\" Alpha=\"1\"><![CDATA[liver]]></Label>"
      "<Label Key=\"2\"><![CDATA[left lobe & "
      "more]]></Label></LabelTable></VolumeInformation></CaretExtension>";
  const struct {
    int kind;
    std::string text;
  } cases[] = {{0, xml},
               {30, xml},
               {6, R"({"1": "liver", "2": "left lobe & more"})"},
               {6, R"({"labels": {"liver": 1, "left lobe & more": 2}})"},
               {44, R"({1: 'liver', 2: 'left lobe & more'})"}};
  for (const auto& c : cases) {
    const fs::path file = fresh_folder() / "s.nii";
    write(file, nifti_with(c.kind, c.text));
    const auto read = read_labels(file);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->names, (LabelNames{{1, "liver"}, {2, "left lobe & more"}})) << c.text;
    EXPECT_EQ(read->labels.samples[1], 1);
  }
}

// An extension without names is ignored.
TEST(NiftiFile, IgnoresExtensionWithoutNames) {
  for (const char* text : {"made by hand", "<a><b>", "{", "{\"a\": \"b\"}", "<Label Key=\"0\">x</Label>"}) {
    const fs::path file = fresh_folder() / "s.nii";
    write(file, nifti_with(6, text));
    const auto read = read_labels(file);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_FALSE(read->has_names) << text;
  }
}

}  // namespace
}  // namespace turgor
