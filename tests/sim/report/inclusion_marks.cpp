#include "turgor/sim/report/inclusion_marks.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// A tick of a tool that is pressed along −z and moves along x at 1 m/s; a tick is 1 ms.
ForceSample tick_at(int i, Vec3d force) {
  ForceSample tick;
  tick.time = i * 1e-3, tick.position = {i * 1e-3, 0, 0}, tick.force = force;
  return tick;
}

TouchLog slide(Vec3d force, int first_touch = 0) {
  TouchLog log;
  log.start({});
  for (int i = 0; i < 100; i++) log.append(tick_at(i, i < first_touch ? Vec3d{} : force));
  return log;
}

const std::vector<InnerRegion> kNodules{
    {.name = "near", .vertices = {}, .triangles = {}, .center = {0.0305, 0.002, -0.02}, .radius = 0.005},
    {.name = "beside", .vertices = {}, .triangles = {}, .center = {0.07, 0.009, -0.02}, .radius = 0.005}};

// A tool is over an inclusion while the line of its force passes through it.
TEST(InclusionMarks, ForceLineThroughInclusion) {
  const Json over = over_inclusions(slide({0, 0, 0.3}), kNodules);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_EQ(over[0].at("inclusion"), "near");
  const double half = std::sqrt(0.005 * 0.005 - 0.002 * 0.002);  // half chord of the sphere, off its center
  EXPECT_NEAR(over[0].at("from_s").get<double>(), 0.0305 - half, 1.1e-3);
  EXPECT_NEAR(over[0].at("to_s").get<double>(), 0.0305 + half, 1.1e-3);
}

// An inclined force shifts the mark, and a pull away from the inclusion has none.
TEST(InclusionMarks, InclinedForceShiftsMark) {
  const Json leaning = over_inclusions(slide({-0.1, 0, 0.2}), kNodules);  // inclined to +x
  ASSERT_EQ(leaning.size(), 1u);
  EXPECT_LT(leaning[0].at("to_s").get<double>(), 0.0305 - 0.003);
  EXPECT_TRUE(over_inclusions(slide({0, 0, -0.3}), kNodules).empty());
}

// Without a force no inclusion is marked.
TEST(InclusionMarks, ZeroForceHasNoMark) {
  const Json over = over_inclusions(slide({0, 0, 0.3}, 32), kNodules);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_NEAR(over[0].at("from_s").get<double>(), 0.032, 1e-9);
  EXPECT_TRUE(over_inclusions(slide({}), kNodules).empty());
}

// A path that passes an inclusion twice has two marks.
TEST(InclusionMarks, ReturningPathIsMarkedTwice) {
  TouchLog log;
  log.start({});
  for (int i = 0; i < 100; i++) {
    ForceSample tick = tick_at(i, {0, 0, 0.3});
    tick.position.x = 0.001 * (i < 50 ? i : 99 - i);
    log.append(tick);
  }
  const Json over = over_inclusions(log, kNodules);
  ASSERT_EQ(over.size(), 2u);
  EXPECT_LT(over[0].at("to_mm").get<double>(), over[1].at("from_mm").get<double>());
}

}  // namespace
}  // namespace turgor
