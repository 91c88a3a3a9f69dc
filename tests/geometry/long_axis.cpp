// Long axes of labels.
#include "turgor/geometry/long_axis.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// The long axis of an oblique ellipsoid is found within a degree, in the patient frame of a turned grid. A
// label without voxels has none, and a single voxel has any.
TEST(LongAxis, IsThatOfEllipsoid) {
  const Vec3d axis = normalized(Vec3d{0.3, -0.5, 0.8});
  LabelVolume labels;
  labels.grid.size = {40, 44, 36};
  labels.grid.spacing = {0.002, 0.0015, 0.0025};
  labels.grid.axes = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  labels.grid.origin = {0.1, -0.2, 0.3};
  labels.samples.assign(sample_count(labels.grid), 0);
  const Vec3d center = point_at(labels.grid, Vec3d{20, 22, 18});
  for (int k = 0; k < labels.grid.size.z; k++)
    for (int j = 0; j < labels.grid.size.y; j++)
      for (int i = 0; i < labels.grid.size.x; i++) {
        const Vec3d d = point_at(labels.grid, Vec3d(Int3{i, j, k})) - center;
        const double along = dot(d, axis), across = norm(d - axis * along);
        if (std::hypot(along / 0.025, across / 0.011) < 1) labels.at(i, j, k) = 7;
      }
  labels.at(0, 0, 0) = 9;
  const Vec3d found = long_axis(labels, 7);
  EXPECT_GT(dot(found, axis), std::cos(0.0175));
  EXPECT_NEAR(norm(found), 1, 1e-9);
  EXPECT_EQ(norm(long_axis(labels, 8)), 0);
  EXPECT_EQ(norm(long_axis(labels, 9)), 1);
}

}  // namespace
}  // namespace turgor
