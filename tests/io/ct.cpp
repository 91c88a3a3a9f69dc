#include "turgor/io/ct.hpp"

#include <cmath>
#include <limits>

#include <sys/stat.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::fresh_folder;
using test::write;

const Exec kExec(2);

/// Axes rotated about all three directions.
Mat3d oblique_axes() {
  const Vec3d i = normalized(Vec3d{0.9, 0.3, -0.1}), k = normalized(cross(i, Vec3d{0.1, 0.95, 0.2}));
  return {{i, cross(k, i), k}};
}

CtVolume make_ct() {
  CtVolume ct{{.size = {7, 5, 4},
               .spacing = {0.7e-3, 1.1e-3, 2.5e-3},
               .origin = {-0.12, 0.034, -0.785},
               .axes = oblique_axes()},
              {}};
  for (std::size_t n = 0; n < sample_count(ct.grid); n++)
    ct.samples.push_back(std::int16_t(int(n * 487 % 4000) - 1024));
  ct.samples[3] = std::numeric_limits<std::int16_t>::min();
  ct.samples[9] = std::numeric_limits<std::int16_t>::max();
  return ct;
}

double largest_shift(const Grid& a, const Grid& b) {
  double shift = 0;
  for (const Vec3d corner : {Vec3d{0, 0, 0}, Vec3d{6, 0, 0}, Vec3d{0, 4, 0}, Vec3d{0, 0, 3}, Vec3d{6, 4, 3}})
    shift = std::max(shift, norm(point_at(a, corner) - point_at(b, corner)));
  return shift;
}

class EveryFormat : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Ct, EveryFormat, ::testing::Values("a.nii", "a.nii.gz", "a.nrrd", "a.mha"));

// A CT with oblique axes and anisotropic spacing is read back with its grid and samples.
TEST_P(EveryFormat, ObliqueCtRoundTrips) {
  const std::filesystem::path folder = fresh_folder();
  const CtVolume ct = make_ct();
  const Status written = write_ct(folder / GetParam(), ct);
  ASSERT_TRUE(written) << written.error().message;
  const auto read = read_ct(kExec, folder / GetParam());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.grid.size, ct.grid.size);
  EXPECT_LT(largest_shift(read->ct.grid, ct.grid), 1e-7);
  EXPECT_TRUE(same_grid(read->ct.grid, ct.grid));
  EXPECT_EQ(read->ct.samples, ct.samples);
}

// Labels are read back exactly.
TEST_P(EveryFormat, LabelsRoundTrip) {
  const std::filesystem::path folder = fresh_folder();
  LabelVolume labels{make_ct().grid, {}};
  for (std::size_t n = 0; n < sample_count(labels.grid); n++)
    labels.samples.push_back(std::uint16_t(n * 521));
  ASSERT_TRUE(write_labels(folder / GetParam(), labels));
  const auto read = read_labels(folder / GetParam());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->labels.samples, labels.samples);
}

// Displacement fields are written in millimeters and read back in millimeters.
TEST_P(EveryFormat, DisplacementsAreStoredInMillimeters) {
  const std::filesystem::path folder = fresh_folder();
  VectorVolume field{make_ct().grid, {}};
  for (std::size_t n = 0; n < sample_count(field.grid); n++)
    field.samples.push_back({float(n) * 1e-3f, -2e-3f, 0.5e-3f * float(n % 3)});
  const Status written = write_displacement(folder / GetParam(), field);
  ASSERT_TRUE(written) << written.error().message;
  const auto read = read_vectors(folder / GetParam());
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->samples.size(), field.samples.size());
  EXPECT_LT(largest_shift(read->grid, field.grid), 1e-7);
  for (std::size_t n = 0; n < field.samples.size(); n++)
    EXPECT_LT(norm(read->samples[n] - field.samples[n] * 1000.0f), 1e-4f) << n;
}

// A truncated file is rejected and named.
TEST_P(EveryFormat, RejectsTruncatedFile) {
  const std::filesystem::path folder = fresh_folder();
  ASSERT_TRUE(write_ct(folder / GetParam(), make_ct()));
  const std::string whole = bytes_of(folder / GetParam());
  for (const std::size_t kept :
       {whole.size() - 40, whole.size() / 2, std::size_t{100}, std::size_t{3}, std::size_t{0}}) {
    write(folder / GetParam(), whole.substr(0, kept));
    EXPECT_REFUSED(read_ct(kExec, folder / GetParam()), GetParam());
  }
}

// Writing into a missing folder fails, and the error names the folder.
TEST_P(EveryFormat, RejectsMissingFolder) {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_REFUSED(write_ct(folder / "nowhere" / GetParam(), make_ct()), "nowhere", "does not exist");
}

// A CT of vectors, labels with fractions, and vectors of one component are rejected.
TEST_P(EveryFormat, RejectsWrongSampleKind) {
  const std::filesystem::path folder = fresh_folder();
  const Grid grid = make_ct().grid;
  ASSERT_TRUE(write_displacement(folder / GetParam(), {grid, std::vector<Vec3>(sample_count(grid))}));
  EXPECT_REFUSED(read_ct(kExec, folder / GetParam()), "3 components", "expected 1");
  ASSERT_TRUE(write_scalars(folder / GetParam(), {grid, std::vector<float>(sample_count(grid), 1.5f)}));
  EXPECT_REFUSED(read_labels(folder / GetParam()), "1.5", "integers");
  EXPECT_REFUSED(read_vectors(folder / GetParam()), "1 components", "expected 3");
}

// Left-handed axes become right-handed, and every sample keeps its position.
TEST(Ct, LeftHandedAxesBecomeRightHanded) {
  const std::filesystem::path folder = fresh_folder();
  CtVolume ct = make_ct();
  ct.grid.axes.column[0] = -ct.grid.axes.column[0];
  ASSERT_TRUE(write_ct(folder / "a.nii.gz", ct));
  const auto read = read_ct(kExec, folder / "a.nii.gz");
  ASSERT_TRUE(read);
  EXPECT_GT(determinant(read->ct.grid.axes), 0.99);
  for (int i = 0; i < 7; i++) {
    const Vec3d at = index_at(read->ct.grid, point_at(ct.grid, {double(i), 2, 1}));
    EXPECT_EQ(read->ct.at(int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))),
              ct.at(i, 2, 1));
  }
}

// A volume whose samples are farther than 1e9 m from the patient is rejected in every format.
TEST(Ct, RejectsDistantOrigin) {
  const std::filesystem::path folder = fresh_folder();
  const std::string fields[][2] = {
      {"far.nrrd",
       "NRRD0004\ntype: uchar\ndimension: 3\nspace: LPS\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) "
       "(0,0,1)\nencoding: raw\nspace origin: (1e308,0,0)\n\n12345678"},
      {"wide.nrrd",
       "NRRD0004\ntype: uchar\ndimension: 3\nspace: LPS\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) "
       "(0,0,1e100)\nencoding: raw\nspace origin: (0,0,0)\n\n12345678"},
      {"far.mha",
       "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
       "Offset = 0 1e308 0\nElementDataFile = LOCAL\n12345678"}};
  for (const auto& [name, bytes] : fields) {
    write(folder / name, bytes);
    EXPECT_REFUSED(read_ct(kExec, folder / name), name.c_str(), "expected samples within 1e+09 m");
    EXPECT_REFUSED(read_labels(folder / name), name.c_str(), "expected samples within 1e+09 m");
    EXPECT_REFUSED(read_ct_grid(folder / name), name.c_str(), "expected samples within 1e+09 m");
  }
  CtVolume ct = make_ct();
  ct.grid.origin.z = 1e30;
  ASSERT_TRUE(write_ct(folder / "far.nii", ct));
  EXPECT_REFUSED(read_ct(kExec, folder / "far.nii"), "far.nii", "expected samples within 1e+09 m");
}

std::string segmentation(const std::string& keys, const char* sizes = "2 2 2", const char* dimension = "3",
                         const char* directions = "(1,0,0) (0,1,0) (0,0,1)", std::size_t count = 8) {
  std::string samples;
  for (std::size_t n = 0; n < count; n++) samples += char(n % 3);
  return std::string("NRRD0004\ntype: uchar\ndimension: ") + dimension +
         "\nspace: left-posterior-superior\nsizes: " + sizes + "\nspace directions: " + directions +
         "\nencoding: raw\nspace origin: (0,0,0)\n" + keys + "\n" + samples;
}

// Labels of a segmentation have the names that its file states.
TEST(Ct, SegmentNamesComeFromFile) {
  const fs::path file = fresh_folder() / "s.seg.nrrd";
  write(file, segmentation("Segment0_ID:=Segment_1\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
                           "Segment0_Name:=liver\nSegment1_LabelValue:=7\nSegment1_Name:=my tumour\n"));
  const auto read = read_labels(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->has_names);
  EXPECT_EQ(read->names, (LabelNames{{1, "liver"}, {7, "my tumour"}}));
  EXPECT_EQ(read_label_names(file), read->names);
}

// Labels without names get the names of the most common segmentation tool.
TEST(Ct, UnnamedLabelsGetDefaultNames) {
  const fs::path file = fresh_folder() / "s.nrrd";
  write(file, segmentation(""));
  const auto read = read_labels(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_FALSE(read->has_names);
  EXPECT_EQ(read->names.at(5), "liver");
  EXPECT_TRUE(read_label_names(file).empty());
}

// A segmentation in several layers is rejected.
TEST(Ct, RejectsLayeredSegments) {
  const fs::path file = fresh_folder() / "s.seg.nrrd";
  write(file,
        segmentation("Segment0_Name:=liver\nSegment0_Layer:=0\nSegment1_Name:=tumour\nSegment1_Layer:=1\n",
                     "2 2 2 2", "4", "none (1,0,0) (0,1,0) (0,0,1)", 16));
  EXPECT_REFUSED(read_labels(file), "s.seg.nrrd", "several layers (2)", "expected one layer");
}

// Labels on another grid are rejected, and the error states the difference.
TEST(Ct, RejectsLabelsOfOtherGrid) {
  const fs::path file = fresh_folder() / "s.nii";
  LabelVolume labels{make_ct().grid, std::vector<std::uint16_t>(sample_count(make_ct().grid), 1)};
  ASSERT_TRUE(write_labels(file, labels));
  EXPECT_TRUE(read_labels_of(file, labels.grid));
  Grid other = labels.grid;
  other.origin.z += 0.01;
  EXPECT_REFUSED(read_labels_of(file, other), "s.nii", "origin", "expected a segmentation of this CT");
}

// Pipes, devices and broken links are rejected, and no reader blocks on them.
TEST(Ct, RejectsPipesAndDevicesWithoutBlocking) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(mkfifo((folder / "pipe.nii").c_str(), 0600), 0);
  EXPECT_REFUSED(read_ct(kExec, folder / "pipe.nii"), "is a pipe; expected a file");
  EXPECT_REFUSED(read_labels(folder / "pipe.nii"), "is a pipe");
  EXPECT_REFUSED(read_vectors(folder / "pipe.nii"), "is a pipe");
  EXPECT_TRUE(read_label_names(folder / "pipe.nii").empty());
  EXPECT_REFUSED(read_file(folder / "pipe.nii"), "is a pipe");
  EXPECT_REFUSED(read_surface(folder / "pipe.nii", 1), "is a pipe");
  EXPECT_REFUSED(read_solid(folder / "pipe.nii", 1), "is a pipe");
  EXPECT_REFUSED(read_ct(kExec, "/dev/zero"), "is a device; expected a file");
  EXPECT_REFUSED(read_labels("/dev/zero"), "is a device");
  EXPECT_REFUSED(read_file("/dev/zero"), "is a device");
  EXPECT_REFUSED(read_surface("/dev/zero", 1), "is a device");
  EXPECT_FALSE(read_ct(kExec, "/proc/self/mem"));
  EXPECT_FALSE(read_surface("/proc/self/mem", 1));
  fs::create_symlink("nowhere", folder / "link.nii");
  EXPECT_REFUSED(read_ct(kExec, folder / "link.nii"), "a link to a file that does not exist");
}

// A bad field in the header of an NRRD file or MetaImage is rejected and named.
TEST(Ct, BadHeaderFieldIsNamed) {
  const std::filesystem::path folder = fresh_folder();
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n";
  const auto refused = [&](std::string text, const std::string& from, const std::string& to,
                           const char* word) {
    text.replace(text.find(from), from.size(), to);
    const auto file = folder / (text.starts_with("NRRD") ? "a.nrrd" : "a.mha");
    write(file, text + std::string(16, '\0'));
    EXPECT_REFUSED(read_ct(kExec, file), word);
  };
  write(folder / "a.nrrd", nrrd + std::string(16, '\0'));
  EXPECT_TRUE(read_ct(kExec, folder / "a.nrrd"));
  refused(nrrd, "sizes: 2 2 2", "sizes: 2 2 60000", "truncated");
  refused(nrrd, "sizes: 2 2 2", "sizes: 60000 60000 60000", "2^33");
  refused(nrrd, "sizes: 2 2 2", "sizes: 2 2", "dimension");
  refused(nrrd, "sizes: 2 2 2", "sizes: 2 2 -2", "65535");
  refused(nrrd, "type: short", "type: block", "block");
  refused(nrrd, "encoding: raw", "encoding: bzip2", "bzip2");
  refused(nrrd, "encoding: raw", "data file: nowhere.raw\nencoding: raw", "nowhere.raw");
  refused(nrrd, "encoding: raw", "encoding: raw\nencoding: gzip", "twice");
  refused(nrrd, "spacings: 1 1 1", "spacings: 1 nan 1", "finite");
  refused(nrrd, "spacings: 1 1 1", "spacings: 1 0 1", "a.nrrd");
  const std::string mha =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nElementSpacing = 1 "
      "1 1\n"
      "DimSize = 2 2 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  write(folder / "a.mha", mha + std::string(16, '\0'));
  EXPECT_TRUE(read_ct(kExec, folder / "a.mha"));
  refused(mha, "DimSize = 2 2 2", "DimSize = 2 2 3", "truncated");
  refused(mha, "NDims = 3", "NDims = 4", "expected one volume");
  refused(mha, "MET_SHORT", "MET_ARRAY", "MET_ARRAY");
  refused(mha, "LOCAL", "LIST", "LIST");
  refused(mha, "BinaryData = True", "BinaryData = False", "text");
  refused(mha, "ElementSpacing = 1 1 1", "ElementSpacing = 1 1 0", "spacing");
  refused(mha, "BinaryData = True",
          "BinaryData = True\nCompressedData = True\nCompressedDataSize = 99999999999", "CompressedDataSize");
}

// The error for a missing file suggests files with similar names.
TEST(Ct, MissingFileSuggestsSimilarNames) {
  const std::filesystem::path folder = fresh_folder();
  write(folder / "patient.nii.gz", "x");
  EXPECT_REFUSED(read_ct(kExec, folder / "patent.nii.gz"), "does not exist", "did you mean patient.nii.gz");
  EXPECT_REFUSED(read_ct(kExec, folder / "patient"), "did you mean patient.nii.gz");
  EXPECT_REFUSED(read_labels(folder / "no" / "such.nii"), "neither does the folder");
  EXPECT_REFUSED(read_ct(kExec, folder / "patient.nii.gz"), "not a volume");
  EXPECT_REFUSED(write_ct(folder / "a.stl", make_ct()), ".nii.gz", ".nrrd");
}

// Writing replaces an older file as a whole and leaves no temporary file.
TEST(Ct, WriteReplacesFileAtomically) {
  const std::filesystem::path folder = fresh_folder();
  write(folder / "a.nrrd", "an older file");
  ASSERT_TRUE(write_ct(folder / "a.nrrd", make_ct()));
  EXPECT_TRUE(read_ct(kExec, folder / "a.nrrd"));
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder / "")) count++;
  EXPECT_EQ(count, 1u);
}

}  // namespace
}  // namespace turgor
