#include "turgor/geometry/phantom.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turgor/geometry/label_measures.hpp"

namespace turgor {
namespace {

PhantomParams small(PhantomKind kind) {
  PhantomParams params = default_phantom(kind);
  for (int axis = 0; axis < 3; axis++) {
    const int size = std::max(24, params.size[axis] / 6);
    params.spacing[axis] *= double(params.size[axis]) / size;
    params.size[axis] = size;
  }
  return params;
}

std::int16_t hu_at(const CtVolume& ct, Vec3d mm) {
  const Vec3d p = index_at(ct.grid, mm * 1e-3);
  return ct.at(int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z)));
}

/// Sizes of the 6-connected components that are denser than -300 HU, largest first.
std::vector<std::size_t> dense_components(const CtVolume& ct) {
  const Grid& grid = ct.grid;
  std::vector<char> seen(ct.samples.size());
  std::vector<std::size_t> sizes;
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++) {
        std::vector<Int3> stack{{i, j, k}};
        std::size_t size = 0;
        while (!stack.empty()) {
          const Int3 p = stack.back();
          stack.pop_back();
          if (!contains(grid, p)) continue;
          char& mark = seen[sample_index(grid, p.x, p.y, p.z)];
          if (mark || ct.at(p.x, p.y, p.z) < -300) continue;
          mark = 1;
          size++;
          for (int axis = 0; axis < 3; axis++)
            for (const int step : {-1, 1}) {
              Int3 q = p;
              q[axis] += step;
              stack.push_back(q);
            }
        }
        if (size) sizes.push_back(size);
      }
  std::sort(sizes.rbegin(), sizes.rend());
  return sizes;
}

class EveryPhantom : public ::testing::TestWithParam<PhantomKind> {};
INSTANTIATE_TEST_SUITE_P(Phantom, EveryPhantom,
                         ::testing::Values(PhantomKind::kTorso, PhantomKind::kHead, PhantomKind::kLeg));

// One and eight threads give the same bits.
TEST_P(EveryPhantom, EqualBitsOnAnyThreads) {
  const auto one = make_phantom(Exec(1), small(GetParam())), eight = make_phantom(Exec(8), small(GetParam()));
  EXPECT_EQ(one.samples, eight.samples);
}

// Another seed gives another noise.
TEST_P(EveryPhantom, SeedChangesNoise) {
  PhantomParams params = small(GetParam());
  const auto first = make_phantom(Exec(2), params);
  params.seed = 2;
  EXPECT_NE(first.samples, make_phantom(Exec(2), params).samples);
}

// The fractions of air, fat, soft tissue and bone are plausible.
TEST_P(EveryPhantom, TissueFractionsArePlausible) {
  const HuSummary hu = summarize(make_phantom(Exec(2), small(GetParam())));
  EXPECT_GT(hu.air, 0.4);
  EXPECT_GT(hu.fat, 0.01);
  EXPECT_GT(hu.soft, 0.08);
  EXPECT_GT(hu.bone, 0.005);
  EXPECT_GE(hu.lowest, -1024);
  EXPECT_GT(hu.highest, 500);
}

// The body is one component that does not touch the table.
TEST_P(EveryPhantom, BodyDoesNotTouchTable) {
  PhantomParams params = default_phantom(GetParam());  // a few slices at full resolution: the table is thin
  params.size.z = 6;
  params.noise = 0;
  const CtVolume ct = make_phantom(Exec(2), params);
  const auto components = dense_components(ct);
  ASSERT_GE(components.size(), 1u);
  std::size_t all = 0;
  for (const std::size_t size : components) all += size;
  EXPECT_GT(double(components[0]), 0.8 * double(all)) << "the body is by far the largest component";
  EXPECT_LT(double(components[0]), double(all)) << "the table is a separate component";
}

// The middle of the grid is the origin.
TEST_P(EveryPhantom, CenteredAtOrigin) {
  const Grid grid = make_phantom(Exec(2), small(GetParam())).grid;
  const Vec3d middle =
      point_at(grid, {(grid.size.x - 1) / 2.0, (grid.size.y - 1) / 2.0, (grid.size.z - 1) / 2.0});
  EXPECT_LT(norm(middle), 1e-6);
}

// The torso's organs have the expected sides, volumes and densities.
TEST(Phantom, TorsoOrgansHaveExpectedDensities) {
  PhantomParams params = small(PhantomKind::kTorso);
  params.size = {200, 200, 150};
  params.spacing = {2e-3, 2e-3, 2e-3};
  LabelVolume labels;
  const CtVolume ct = make_phantom(Exec(2), params, &labels);
  double liver = 0, nodule = 0;
  for (const LabelMeasure& m : measure_labels(labels, &ct)) {
    if (m.label == 5) {
      liver = m.volume * 1e6;
      EXPECT_NEAR(m.mean_hu, 60, 10);
      EXPECT_LT(m.centroid.x, -0.03) << "the liver lies on the right";
    } else if (m.label == 1) {
      EXPECT_GT(m.centroid.x, 0.03) << "the spleen lies on the left";
    } else if (m.label == 11) {
      EXPECT_NEAR(m.mean_hu, -850, 60);
    } else if (m.label == kNoduleLabel) {
      nodule = m.volume * 1e6;
      EXPECT_NEAR(m.mean_hu, 100, 8);
    }
  }
  EXPECT_GT(liver, 700);
  EXPECT_LT(liver, 1900);
  EXPECT_NEAR(nodule, 4 / 3.0 * M_PI * 1.3 * 1.3 * 1.3, 0.7);
}

// Below the torso's skin lie fat and then muscle.
TEST(Phantom, TorsoIsLayeredBelowSkin) {
  PhantomParams params = small(PhantomKind::kTorso);
  params.size = {200, 800, 40};
  params.spacing = {2e-3, 0.5e-3, 5e-3};
  params.noise = 0;
  const CtVolume ct = make_phantom(Exec(2), params);
  double skin = -199;  // the first dense sample from the front, in the middle
  while (hu_at(ct, {30, skin, -40}) < -300) skin += 0.5;
  EXPECT_NEAR(skin, -18 - 94, 3);
  EXPECT_NEAR(hu_at(ct, {30, skin + 8, -40}), -100, 15) << "fat";
  EXPECT_NEAR(hu_at(ct, {30, skin + 24, -40}), 55, 15) << "muscle";
}

}  // namespace
}  // namespace turgor
