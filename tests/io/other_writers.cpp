// Files of other writers: NIfTI-2 by nibabel, enhanced images and segmentations by highdicom.
#include <gdcmReader.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmWriter.h>

#include "tests/io/dicom/dicom_series.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

const fs::path kCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "ct";
const Vec3d kRow{std::cos(M_PI / 9), std::sin(M_PI / 9), 0},
    kColumn{-kRow.y, kRow.x, 0};  // rotated by 20 degrees

// NIfTI-2 files are read in both byte orders, with grids from sform or qform.
TEST(OtherWriters, ReadsNifti2InBothByteOrders) {
  for (const char* name : {"nifti2.nii", "nifti2-big.nii.gz"}) {
    const Result<CtFile> read = read_ct(Exec(2), kCorpus / name);
    ASSERT_TRUE(read) << read.error().message;
    for (int i = 0; i < 5; i++)
      for (int j = 0; j < 4; j++)
        for (int k = 0; k < 3; k++) {
          const Vec3d ras =
              Vec3d{-10, 20, -30} + kRow * (0.7 * i) + kColumn * (0.8 * j) + Vec3d{0, 0, 1.5 * k};
          const Vec3d at = index_at(read->ct.grid, Vec3d{-ras.x, -ras.y, ras.z} * 1e-3);
          const Int3 n{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
          EXPECT_LT(norm(at - Vec3d(n)), 1e-4);
          EXPECT_EQ(read->ct.at(n.x, n.y, n.z), 100 * i + 10 * j + k - 200);
        }
  }
}

// A NIfTI-2 header that is truncated or states a huge size is rejected.
TEST(OtherWriters, RejectsBadNifti2Header) {
  const fs::path folder = test::fresh_folder();
  const std::string whole = test::bytes_of(kCorpus / "nifti2.nii");
  for (const std::size_t kept : {std::size_t{400}, std::size_t{543}, whole.size() - 1}) {
    test::write(folder / "a.nii", whole.substr(0, kept));
    EXPECT_REFUSED(read_ct(Exec(2), folder / "a.nii"), "a.nii", "truncated");
  }
  std::string large = whole;
  for (int axis = 1; axis <= 3; axis++)
    large.replace(std::size_t(16 + 8 * axis), 8, std::string(7, '\xff') + '\x7f');
  test::write(folder / "a.nii", large);
  EXPECT_REFUSED(read_ct(Exec(2), folder / "a.nii"), "a.nii", "expected 1 to 65535 each");
}

/// Grid of the slices that were written with highdicom.
Grid highdicom_grid() {
  return {.size = {8, 6, 4},
          .spacing = {0.7e-3, 0.9e-3, 2.5e-3},
          .origin = {0.010, -0.020, 0.030},
          .axes = {{kRow, kColumn, Vec3d{0, 0, 1}}}};
}

// Enhanced DICOM images of highdicom are read, plain and compressed.
TEST(OtherWriters, ReadsEnhancedImage) {
  for (const bool compressed : {false, true}) {
    const fs::path folder = test::fresh_folder();
    fs::copy(kCorpus / (compressed ? "enhanced-j2k.dcm" : "enhanced.dcm"), folder / "a.dcm");
    const Result<CtFile> read = read_ct(Exec(2), folder);
    ASSERT_TRUE(read) << read.error().message;
    Grid grid = highdicom_grid();
    if (compressed) grid.size = {48, 40, 4};
    EXPECT_TRUE(same_grid(read->ct.grid, grid));
    EXPECT_EQ(read->patient, "High^Dicom");
    const int along = compressed ? 10 : 100, down = compressed ? 5 : 10;
    for (int k = 0; k < grid.size.z; k++)
      for (int j = 0; j < grid.size.y; j++)
        for (int i = 0; i < grid.size.x; i++) EXPECT_EQ(read->ct.at(i, j, k), along * i + down * j + k - 500);
  }
}

// A DICOM segmentation is read onto the grid of its CT with the names of its segments.
TEST(OtherWriters, ReadsDicomSegmentation) {
  const Result<LabelFile> read = read_labels_of(kCorpus / "segmentation.dcm", highdicom_grid());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->names, (LabelNames{{1, "liver"}, {2, "left kidney"}}));
  EXPECT_TRUE(read->has_names);
  EXPECT_EQ(read_label_names(kCorpus / "segmentation.dcm"), read->names);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 6; j++)
      for (int i = 0; i < 8; i++) {
        const bool liver = (k == 1 || k == 2) && (j == 2 || j == 3) && i >= 3 && i < 6;
        EXPECT_EQ(read->labels.at(i, j, k), liver ? 1 : k == 2 && j < 2 && i < 2 ? 2 : 0) << i << j << k;
      }
}

// Without a stated distance, that of the frames is used and not the thickness of the slices.
TEST(OtherWriters, SegmentationNeedsNoSpacingBetweenSlices) {
  const Result<LabelFile> stated = read_labels_of(kCorpus / "segmentation.dcm", highdicom_grid());
  ASSERT_TRUE(stated) << stated.error().message;
  std::string bytes = test::bytes_of(kCorpus / "segmentation.dcm");
  const auto element = [&bytes](unsigned char number) {
    const std::string tag{0x18, 0, char(number), 0, 'D', 'S'};
    return bytes.find(tag);
  };
  // another element takes the tag of the distance
  const std::size_t distance = element(0x88), thickness_at = element(0x50);
  ASSERT_NE(distance, std::string::npos);
  ASSERT_NE(thickness_at, std::string::npos);
  bytes[distance + 2] = char(0x87);
  for (const char* thickness : {"1", "5", "9"}) {
    const std::size_t length = std::size_t(bytes[thickness_at + 6]);
    std::string value = thickness;
    value.resize(length, ' ');
    bytes.replace(thickness_at + 8, length, value);
    const fs::path file = test::fresh_folder() / "a.dcm";
    test::write(file, bytes);
    const Result<LabelFile> read = read_labels_of(file, highdicom_grid());
    ASSERT_TRUE(read) << thickness << ": " << read.error().message;
    EXPECT_EQ(read->labels.samples, stated->labels.samples) << thickness;
  }
}

/// Replaces the value of the last element with this tag, a decimal string, by one of the same length.
void set_last_decimal(std::string& bytes, const std::string& tag, std::string value) {
  const std::size_t at = bytes.rfind(tag + "DS");
  ASSERT_NE(at, std::string::npos);
  const auto length = std::size_t(bytes[at + 6]);
  ASSERT_LE(value.size(), length);
  value.resize(length, ' ');
  bytes.replace(at + 8, length, value);
}

const std::string kDistanceTag("\x18\0\x88\0", 4), kPositionTag("\x20\0\x32\0", 4);

// A stated distance that contradicts the positions of the frames, or is rounded, does not change the grid.
TEST(OtherWriters, SegmentationDistanceIsThatOfFrames) {
  const Result<LabelFile> sound = read_labels_of(kCorpus / "segmentation.dcm", highdicom_grid());
  ASSERT_TRUE(sound) << sound.error().message;
  for (const char* distance : {"-1", "0", "2.55", "2.45", "5", "1", "9e9"}) {
    std::string bytes = test::bytes_of(kCorpus / "segmentation.dcm");
    set_last_decimal(bytes, kDistanceTag, distance);
    const fs::path file = test::fresh_folder() / "a.dcm";
    test::write(file, bytes);
    const Result<LabelFile> read = read_labels_of(file, highdicom_grid());
    ASSERT_TRUE(read) << distance << ": " << read.error().message;
    EXPECT_EQ(read->labels.samples, sound->labels.samples) << distance;
  }
}

// Frames of several segments in one plane may have positions that are rounded differently.
TEST(OtherWriters, SegmentationPlanesMayBeRounded) {
  const Result<LabelFile> sound = read_labels(kCorpus / "segmentation.dcm");
  std::string bytes = test::bytes_of(kCorpus / "segmentation.dcm");
  set_last_decimal(bytes, kPositionTag, "10.\\-20.\\35.003");
  const fs::path file = test::fresh_folder() / "a.dcm";
  for (const char* distance : {"2.5", "2.55", "-1"}) {
    set_last_decimal(bytes, kDistanceTag, distance);
    test::write(file, bytes);
    const Result<LabelFile> read = read_labels(file);
    ASSERT_TRUE(sound && read) << distance << ": " << read.error().message;
    EXPECT_EQ(read->labels.samples, sound->labels.samples) << distance;
  }
}

// The distance of frames is their mean, where planes between them have no frame, and where a stated half of
// it says that planes lie between all of them.
TEST(OtherWriters, SegmentationDistanceIsMeanOfGaps) {
  std::string bytes = test::bytes_of(kCorpus / "segmentation.dcm");
  set_last_decimal(bytes, kPositionTag, "10.0\\-20.0\\40.0");  // two planes above the next one
  const fs::path file = test::fresh_folder() / "a.dcm";
  for (const auto& [distance, spacing] :
       {std::pair("2.5", 2.5), {"2.55", 2.5}, {"-1", 2.5}, {"1.25", 1.25}, {"1.26", 1.25}}) {
    set_last_decimal(bytes, kDistanceTag, distance);
    test::write(file, bytes);
    const Result<LabelFile> read = read_labels(file);
    ASSERT_TRUE(read) << distance << ": " << read.error().message;
    EXPECT_NEAR(read->labels.grid.spacing.z * 1e3, spacing, 1e-9) << distance;
    EXPECT_EQ(read->labels.grid.size.z, spacing == 2.5 ? 4 : 7) << distance;
  }
}

// The refusal of a segmentation of another CT names their difference. Its size is not one: a segmentation has
// the planes of its segments only.
TEST(OtherWriters, SegmentationOfOtherCtNamesDifference) {
  const fs::path file = kCorpus / "segmentation.dcm";
  Grid larger = highdicom_grid();
  larger.size = {16, 12, 9};
  EXPECT_TRUE(read_labels_of(file, larger)) << "the same samples, and more";
  Grid other = larger;
  other.origin += Vec3d{0.2e-3, 0, 0};
  EXPECT_REFUSED(read_labels_of(file, other), "segmentation.dcm: its grid differs from the CT's: origin ",
                 "between samples", "expected a segmentation of this CT");
  other = larger, other.origin = point_at(larger, {0, 0, 2});
  EXPECT_REFUSED(read_labels_of(file, other), "CT's: origin ",
                 "it reaches from sample (0, 0, -1) to (7, 5, 0)", "outside of 16 x 12 x 9 samples");
  other = larger, other.spacing.x = 0.75e-3;
  EXPECT_REFUSED(read_labels_of(file, other), "CT's: spacing 0.7 x 0.9 x 2.5 mm, not 0.75 x 0.9 x 2.5 mm");
}

/// A frame encoded as runs of literal bytes [PS3.5, annex G].
std::string run_lengths(std::string_view samples) {
  std::string code(64, '\0');
  code[0] = 1, code[4] = 64;  // one segment after this header
  for (std::size_t at = 0; at < samples.size(); at += 100) {
    const std::string_view run = samples.substr(at, 100);
    code += char(run.size() - 1);
    code += run;
  }
  return code.size() % 2 ? code + '\0' : code;
}

/// Rewrites the segmentation with fractions instead of bits: just above one half for ones, just below for
/// zeros.
void write_fractions(const fs::path& file, bool compressed, int most) {
  gdcm::Reader reader;
  reader.SetFileName((kCorpus / "segmentation.dcm").c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const auto put = [&set](std::uint16_t group, std::uint16_t element, gdcm::VR vr, std::string bytes) {
    gdcm::DataElement e(gdcm::Tag(group, element));
    e.SetVR(vr);
    e.SetByteValue(bytes.data(), std::uint32_t(bytes.size()));
    set.Replace(e);
  };
  const gdcm::ByteValue* bits = set.GetDataElement(gdcm::Tag(0x7fe0, 0x0010)).GetByteValue();
  constexpr std::size_t kArea = 8 * 6;
  std::string bytes;
  for (std::size_t n = 0; n < bits->GetLength() * 8 / kArea * kArea; n++)
    bytes += char((bits->GetPointer()[n / 8] >> (n % 8) & 1) != 0 ? (most + 1) / 2 : (most - 1) / 2);
  put(0x0062, 0x0001, gdcm::VR::CS, "FRACTIONAL");
  put(0x0062, 0x0010, gdcm::VR::CS, "OCCUPANCY ");
  put(0x0062, 0x000e, gdcm::VR::US, std::string{char(most), '\0'});
  for (const auto& [element, value] : {std::pair{0x0100, 8}, {0x0101, 8}, {0x0102, 7}})
    put(0x0028, std::uint16_t(element), gdcm::VR::US, std::string{char(value), '\0'});
  if (compressed) {
    const gdcm::SmartPointer<gdcm::SequenceOfFragments> frames = new gdcm::SequenceOfFragments;
    for (std::size_t at = 0; at < bytes.size(); at += kArea) {
      const std::string code = run_lengths(std::string_view(bytes).substr(at, kArea));
      gdcm::Fragment fragment;
      fragment.SetByteValue(code.data(), std::uint32_t(code.size()));
      frames->AddFragment(fragment);
    }
    gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
    pixels.SetVR(gdcm::VR::OB);
    pixels.SetValue(*frames);
    set.Replace(pixels);
  } else {
    put(0x7fe0, 0x0010, gdcm::VR::OB, bytes);
  }
  reader.GetFile().GetHeader().SetDataSetTransferSyntax(
      compressed ? gdcm::TransferSyntax::RLELossless : gdcm::TransferSyntax::ExplicitVRLittleEndian);
  gdcm::Writer writer;
  writer.SetFile(reader.GetFile());
  writer.SetFileName(file.c_str());
  ASSERT_TRUE(writer.Write());
}

// Fractions of at least one half become labels, in plain and compressed segmentations.
TEST(OtherWriters, ThresholdsFractionalSegmentation) {
  const fs::path file = test::fresh_folder() / "a.dcm";
  const LabelVolume bits = read_labels(kCorpus / "segmentation.dcm").value().labels;
  for (const bool compressed : {false, true})
    for (const int most : {255, 101, 7}) {
      write_fractions(file, compressed, most);
      const Result<LabelFile> read = read_labels(file);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->labels.samples, bits.samples) << compressed << " " << most;
      EXPECT_EQ(read->names, (LabelNames{{1, "liver"}, {2, "left kidney"}}));
    }
}

// A truncated fractional segmentation gives an error message.
TEST(OtherWriters, RejectsTruncatedFractions) {
  const fs::path file = test::fresh_folder() / "a.dcm";
  for (const bool compressed : {false, true}) {
    write_fractions(file, compressed, 255);
    const std::string whole = test::bytes_of(file);
    for (std::size_t kept = whole.size() - 20; kept > 300; kept -= std::min<std::size_t>(kept, 397)) {
      test::write(file, whole.substr(0, kept));
      EXPECT_REFUSED(read_labels(file), "a.dcm");
    }
  }
}

// A deflated segmentation is read; a truncated one is rejected and named.
TEST(OtherWriters, ReadsDeflatedSegmentation) {
  const fs::path file = test::fresh_folder() / "a.dcm";
  gdcm::Reader reader;
  reader.SetFileName((kCorpus / "segmentation.dcm").c_str());
  ASSERT_TRUE(reader.Read());
  reader.GetFile().GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian);
  gdcm::Writer writer;
  writer.SetFile(reader.GetFile());
  writer.SetFileName(file.c_str());
  ASSERT_TRUE(writer.Write());
  const Result<LabelFile> read = read_labels(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->labels.samples, read_labels(kCorpus / "segmentation.dcm").value().labels.samples);
  const std::string whole = test::bytes_of(file);
  test::write(file, whole.substr(0, whole.size() - 64));
  EXPECT_REFUSED(read_labels(file), "a.dcm");
}

// A DICOM segmentation on another grid, or with overlapping segments, is rejected.
TEST(OtherWriters, RejectsOverlapsAndOtherGrids) {
  Grid shifted = highdicom_grid();
  shifted.origin.x += 0.3e-3;
  EXPECT_REFUSED(read_labels_of(kCorpus / "segmentation.dcm", shifted), "its grid differs from the CT's");
  Grid smaller = highdicom_grid();
  smaller.size.z = 2;
  EXPECT_REFUSED(read_labels_of(kCorpus / "segmentation.dcm", smaller), "its grid differs from the CT's");
  EXPECT_REFUSED(read_labels(kCorpus / "segmentation-overlap.dcm"),
                 "segments 1 and 2 overlap at sample (3, 2, ");
  EXPECT_REFUSED(read_labels(kCorpus / "enhanced.dcm"), "not a segmentation");
}

// A truncated segmentation is rejected; one with flipped bits does not crash the reader.
TEST(OtherWriters, DamagedSegmentationIsSafe) {
  const fs::path folder = test::fresh_folder();
  const std::string whole = test::bytes_of(kCorpus / "segmentation.dcm");
  for (std::size_t kept = whole.size() - 2; kept > 300; kept -= std::min<std::size_t>(kept, 37)) {
    test::write(folder / "a.dcm", whole.substr(0, kept));
    EXPECT_REFUSED(read_labels(folder / "a.dcm"), "a.dcm");
  }
  for (std::size_t at = 132; at < whole.size(); at += 7) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 0x41);
    test::write(folder / "a.dcm", damaged);
    (void)read_labels(folder / "a.dcm");  // gives labels or an error
  }
}

}  // namespace
}  // namespace turgor
