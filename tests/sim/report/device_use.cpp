#include "turgor/sim/report/device_use.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// A tool that presses a spring of 700 N/m by 5 mm along an oblique line, and returns.
TouchLog pressed_spring() {
  const Vec3d along = normalized(Vec3d{1, 2, -2});
  TouchLog log;
  for (int tick = 0; tick <= 200; tick++) {
    const double depth = 0.005 * (1 - std::abs(tick - 100) / 100.0);
    ForceSample sample;
    sample.time = tick * kTick;
    sample.position = along * depth;
    sample.force = along * (-700 * depth);
    log.append(sample);
  }
  return log;
}

// A spring has its stiffness, its largest force and half of its path's longest side.
TEST(DeviceUse, SpringHasItsStiffness) {
  const DeviceUse use = device_use(pressed_spring(), 2.79);
  EXPECT_NEAR(use.stiffness, 700, 1e-6);
  EXPECT_NEAR(use.force, 3.5, 1e-9);
  EXPECT_NEAR(use.reach, 0.5 * 0.005 * 2 / 3, 1e-9);
  // 2.79 N are reached at 3.986 mm, between ticks 79 and 80 of 100, and left between 120 and 121
  EXPECT_EQ(use.saturated, 41u);
}

// A drop of the force is not a stiffness, and a resting tool has none.
TEST(DeviceUse, DropsAndRestsHaveNoStiffness) {
  TouchLog punctured;
  for (int tick = 0; tick <= 100; tick++) {
    ForceSample sample;
    sample.position.z = -5e-5 * tick;
    sample.force.z = tick < 60 ? 0.035 * tick : 0.1;
    punctured.append(sample);
  }
  EXPECT_NEAR(felt_stiffness(punctured), 700, 1e-6);
  TouchLog resting;
  for (int tick = 0; tick < 50; tick++) {
    ForceSample sample;
    sample.force = {0, 0, 0.1 * tick};
    resting.append(sample);
  }
  EXPECT_EQ(felt_stiffness(resting), 0);
  EXPECT_EQ(device_use({}, 0).force, 0);
}

}  // namespace
}  // namespace turgor
