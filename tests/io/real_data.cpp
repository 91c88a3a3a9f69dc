// Known facts about real CTs: volumes and centroids of organs, in several formats.
#include <gtest/gtest.h>

#include "turgor/geometry/label_measures.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(TURGOR_SOURCE_DIR) / ".." / "shared" / "data" / "ct";

#define SKIP_WITHOUT(path) \
  if (!fs::exists(path)) GTEST_SKIP() << (path).string() << " is absent: real data is not part of the project"

struct Known {
  int label;
  std::size_t voxels;
  double volume_ml;
  Vec3d centroid_ras_mm;
  double mean_hu;
};

void expect_known(const char* ct_name, const char* labels_name, const std::vector<Known>& table) {
  const auto ct = read_ct(Exec(2), kData / ct_name);
  ASSERT_TRUE(ct) << ct.error().message;
  const auto stored = read_labels(kData / labels_name);
  ASSERT_TRUE(stored) << stored.error().message;
  const auto labels = on_grid(stored->labels, ct->ct.grid);
  ASSERT_TRUE(labels) << "the segmentation fits the CT";
  const auto measures = measure_labels(*labels, &ct->ct);
  for (const Known& known : table) {
    const auto found =
        std::find_if(measures.begin(), measures.end(), [&](const auto& m) { return m.label == known.label; });
    ASSERT_NE(found, measures.end()) << known.label;
    EXPECT_EQ(found->voxels, known.voxels);
    EXPECT_NEAR(found->volume * 1e6, known.volume_ml, 1e-3 * known.volume_ml);
    if (norm(known.centroid_ras_mm) > 0) {
      const Vec3d ras = Vec3d{-found->centroid.x, -found->centroid.y, found->centroid.z} * 1e3;
      EXPECT_LT(norm(ras - known.centroid_ras_mm), 0.1);
    }
    if (known.mean_hu != 0) {
      EXPECT_NEAR(found->mean_hu, known.mean_hu, 0.05);
    }
  }
}

// Organs of a NIfTI slab have the known volumes, centroids and densities.
TEST(RealData, NiftiSlabOrgansMatch) {
  SKIP_WITHOUT(kData / "abdomen-slab.nii.gz");
  expect_known("abdomen-slab.nii.gz", "abdomen-slab-labels.nii.gz",
               {{5, 38634, 1043.118, {64.35, 185.03, 150.14}, 45.29},
                {1, 9452, 255.204, {}, 0},
                {2, 3947, 106.569, {}, 0}});
}

// Real CTs are read without notes, so none is suspected of lacking Hounsfield units.
TEST(RealData, CtsGiveNoNotes) {
  SKIP_WITHOUT(kData / "dicom-abdomen");
  for (const char* name : {"abdomen-slab.nii.gz", "dicom-abdomen", "dicom-jpeg2000", "torso-3mm.nii.gz"}) {
    const auto ct = read_ct(Exec(2), kData / name);
    ASSERT_TRUE(ct) << ct.error().message;
    EXPECT_TRUE(ct->notes.empty()) << name << ": " << ct->notes[0];
  }
}

// No lattice node in the patient table counts as body, at any spacing.
TEST(RealData, TableHasNoBodyNodes) {
  SKIP_WITHOUT(kData / "dicom-abdomen");
  const auto ct = read_ct(Exec(2), kData / "dicom-abdomen");
  ASSERT_TRUE(ct) << ct.error().message;
  constexpr double kTable = 0.357;  // front of the table, behind the first row [m]
  for (const double step : {3e-3, 4e-3, 6e-3, 8e-3, 10e-3}) {
    lattice::Params params;
    for (int axis = 0; axis < 3; axis++)
      params.block[axis] = std::max(1, int(std::lround(step / ct->ct.grid.spacing[axis])));
    const auto nodes = lattice::classify(Exec(2), ct->ct, nullptr, params);
    ASSERT_TRUE(nodes) << nodes.error().message;
    const Int3 size = nodes->grid.size;
    std::size_t behind = 0;
    for (std::size_t n = 0; n < nodes->tissue.size(); n++) {
      const double depth = double(n / std::size_t(size.x) % std::size_t(size.y)) * nodes->grid.spacing.y;
      behind += lattice::is_body(nodes->tissue[n]) && depth > kTable;
    }
    EXPECT_EQ(behind, 0u) << "of a lattice with spacing " << step * 1e3 << " mm";
  }
}

// The liver of a JPEG 2000 series, with labels on a mirrored grid, has the known measures.
TEST(RealData, Jpeg2000LiverMatches) {
  SKIP_WITHOUT(kData / "dicom-jpeg2000");
  expect_known("dicom-jpeg2000", "dicom-jpeg2000-labels.nii.gz",
               {{5, 366708, 699.440, {76.00, 165.93, -784.98}, 89.30}});
}

// The torso has the known size and range of Hounsfield units.
TEST(RealData, TorsoHasKnownRange) {
  SKIP_WITHOUT(kData / "torso-3mm.nii.gz");
  const auto ct = read_ct(Exec(2), kData / "torso-3mm.nii.gz");
  ASSERT_TRUE(ct) << ct.error().message;
  EXPECT_EQ(ct->ct.grid.size, (Int3{122, 101, 112}));
  const HuSummary hu = summarize(ct->ct);
  EXPECT_EQ(hu.lowest, -1207);
  EXPECT_EQ(hu.highest, 3382);
}

}  // namespace
}  // namespace turgor
