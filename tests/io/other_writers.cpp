// Files that others wrote: NIfTI-2 by nibabel, enhanced images and segmentations by highdicom.
#include "io/dicom_series.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

const fs::path kCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "ct";
const Vec3d kRow{std::cos(M_PI / 9), std::sin(M_PI / 9), 0},
    kColumn{-kRow.y, kRow.x, 0};  // turned by 20 degrees

TEST(OtherWriters, ANifti2FileIsReadInBothByteOrdersByItsSformOrItsQform) {
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

TEST(OtherWriters, ANifti2HeaderThatIsCutShortOrPromisesTooMuchIsRefused) {
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

/// The grid of the slices that highdicom was given.
Grid highdicom_grid() {
  return {.size = {8, 6, 4},
          .spacing = {0.7e-3, 0.9e-3, 2.5e-3},
          .origin = {0.010, -0.020, 0.030},
          .axes = {{kRow, kColumn, Vec3d{0, 0, 1}}}};
}

TEST(OtherWriters, AnEnhancedImageIsReadPlainAndCompressed) {
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

TEST(OtherWriters, ADicomSegmentationLiesOnItsCtWithItsNames) {
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

TEST(OtherWriters, ADicomSegmentationOfAnotherGridOrWithOverlapsIsRefused) {
  Grid shifted = highdicom_grid();
  shifted.origin.x += 0.3e-3;
  EXPECT_REFUSED(read_labels_of(kCorpus / "segmentation.dcm", shifted), "its grid is not the CT's");
  Grid smaller = highdicom_grid();
  smaller.size.z = 2;
  EXPECT_REFUSED(read_labels_of(kCorpus / "segmentation.dcm", smaller), "its grid is not the CT's");
  EXPECT_REFUSED(read_labels(kCorpus / "segmentation-overlap.dcm"),
                 "segments 1 and 2 overlap at sample (3, 2, ");
  EXPECT_REFUSED(read_labels(kCorpus / "enhanced.dcm"), "no segmentation");
}

TEST(OtherWriters, ADamagedSegmentationEndsInASentence) {
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
    (void)read_labels(folder / "a.dcm");  // labels or a sentence
  }
}

}  // namespace
}  // namespace turgor
