#include "turgor/models/sfem/surface_strain.hpp"

#include <gtest/gtest.h>

namespace turgor::sfem {
namespace {

Patch triangle() {
  Patch patch;
  for (const Vec3d x : {Vec3d{0, 0, 0}, Vec3d{0.02, 0.001, 0}, Vec3d{0.005, 0.01, 0.003}})
    patch.points.push_back({.x = x});
  patch.triangles = {{0, 1, 2}};
  return patch;
}

std::vector<Vec3d> moved(const Patch& patch, const Mat3d& f) {
  std::vector<Vec3d> x;
  for (const PatchPoint& p : patch.points) x.push_back(f * p.x + Vec3d{1, 2, 3});
  return x;
}

// Uniform stretches give ½ (λ² − 1), rotations none.
TEST(SurfaceStrain, UniformStretchAndRotation) {
  const Patch patch = triangle();
  const Mat3d turned{{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}};
  EXPECT_NEAR(largest_surface_strain(patch, moved(patch, turned)), 0, 1e-12);
  for (const double stretch : {0.7, 1.3}) {
    const Mat3d f{{turned.column[0] * stretch, turned.column[1] * stretch, turned.column[2] * stretch}};
    EXPECT_NEAR(largest_surface_strain(patch, moved(patch, f)), std::abs(stretch * stretch - 1) / 2, 1e-12);
  }
}

}  // namespace
}  // namespace turgor::sfem
