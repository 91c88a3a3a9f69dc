#include "turgor/models/rhombus/surface_stiffness.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/rhombus/bodies.hpp"

namespace turgor::rhombus {
namespace {

/// Samples of 2 mm around the slab: `inside` in a ball below its top, `outside` elsewhere.
template <class T>
Volume<T> ball_below(T inside, T outside) {
  Volume<T> volume{{.size = {61, 61, 31}, .spacing = {2e-3, 2e-3, 2e-3}, .origin = {-0.06, -0.06, -0.05}},
                   {}};
  for (int k = 0; k < 31; k++)
    for (int j = 0; j < 61; j++)
      for (int i = 0; i < 61; i++) {
        const Vec3d x = point_at(volume.grid, {double(i), double(j), double(k)});
        volume.samples.push_back(norm(x - Vec3d{0, 0, -0.008}) < 0.006 ? inside : outside);
      }
  return volume;
}

double at(const Surface& s, const std::vector<double>& value, Vec3d position) {
  double nearest = 1, found = 0;
  for (std::size_t v = 0; v < s.vertices.size(); v++)
    if (const double d = norm(s.vertices[v] - position); d < nearest) nearest = d, found = value[v];
  return found;
}

// A hard nodule stiffens the surface above it and not beside it.
TEST(RhombusSurfaceStiffness, NoduleStiffensSurfaceAboveIt) {
  const Surface surface = test::slab(0.1, 50, 0.2);
  const LabelVolume labels = ball_below<std::uint16_t>(7, 1);
  const auto stiffness = stiffness_below(surface, 0.02, factor_of_labels(labels, {{7, 10.0}}));
  EXPECT_GT(at(surface, stiffness, {0, 0, 0}), 1.5);
  EXPECT_LT(at(surface, stiffness, {0, 0, 0}), 10);
  EXPECT_NEAR(at(surface, stiffness, {0.03, 0, 0}), 1, 1e-9);
  for (const double k : stiffness) EXPECT_GE(k, 1 - 1e-12);
}

// A uniform CT scales the whole surface by the factor of its value.
TEST(RhombusSurfaceStiffness, UniformCtScalesSurface) {
  const Surface surface = test::slab(0.04, 10, 0.2);
  const CtVolume ct = ball_below<std::int16_t>(50, 50);
  const auto stiffness = stiffness_below(surface, 0.004, factor_of_ct(ct, {{0.0, 1.0}, {100.0, 3.0}}));
  for (const double k : stiffness) EXPECT_NEAR(k, 2, 1e-12);
}

}  // namespace
}  // namespace turgor::rhombus
