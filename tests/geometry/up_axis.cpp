#include "turgor/geometry/up_axis.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// A rotation, not a reflection, maps the up axis to z.
TEST(UpAxis, RotatesUpAxisToZ) {
  const Vec3d axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const UpAxis up : {UpAxis::kX, UpAxis::kY, UpAxis::kZ}) {
    EXPECT_EQ(turned_up(axes[int(up)], up), axes[2]);
    const Vec3d x = turned_up(axes[0], up), y = turned_up(axes[1], up), z = turned_up(axes[2], up);
    EXPECT_EQ(dot(cross(x, y), z), 1) << "a mirror would turn surfaces inside out";
    EXPECT_FALSE(std::signbit(turned_up(Vec3d{}, up).x) || std::signbit(turned_up(Vec3d{}, up).y));
  }
  EXPECT_EQ(turned_up(Vec3d{1, 2, 3}, UpAxis::kY), (Vec3d{1, -3, 2})) << "the convention of cloth scenes";
}

}  // namespace
}  // namespace turgor
