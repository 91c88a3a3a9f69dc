#include "turgor/models/lattice/build/surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {
namespace {

const Int3 kSize{240, 200, 60};
constexpr double kSpacing = 1e-3;  // [m]
constexpr double kBack = 120;      // back of the body, voxels along j

/// A CT of 1 mm voxels with tissue where `dense(x, y, z)`.
CtVolume painted(const std::function<bool(double, double, double)>& dense) {
  CtVolume ct{{.size = kSize, .spacing = {kSpacing, kSpacing, kSpacing}, .origin = {}, .axes = {}}, {}};
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++) ct.samples.push_back(dense(i, j, k) ? 40 : kAirHu);
  return ct;
}

/// An oval body on its back, flat over 60 mm.
bool in_body(double x, double y) {
  const double u = (x - 120) / 90, v = (y - 70) / 55;
  return u * u + v * v < 1 && y < kBack;
}

BodyNodes nodes_at(const CtVolume& ct, int step) {
  Params params;
  params.block = {step, step, step};
  return classify(Exec(2), ct, nullptr, params).value();
}

/// Number of body nodes at depths [from, to) along j [mm].
std::size_t count_nodes(const BodyNodes& nodes, double from, double to) {
  std::size_t count = 0;
  for (std::size_t n = 0; n < nodes.tissue.size(); n++) {
    const double depth = double(n / std::size_t(nodes.grid.size.x) % std::size_t(nodes.grid.size.y)) *
                         nodes.grid.spacing.y * 1e3;
    count += is_body(nodes.tissue[n]) && depth >= from && depth < to;
  }
  return count;
}

struct Table {
  const char* name;
  double gap, sheet, thickness;  // distance to the back, thickness of the shell, total thickness [mm]
};

class BehindTheBody : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Surroundings, BehindTheBody, ::testing::Values(3, 6, 8, 10));

// No node lies in a table near the body.
TEST_P(BehindTheBody, NearTableHasNoNodes) {
  const CtVolume alone = painted([](double x, double y, double) { return in_body(x, y); });
  const std::size_t nodes_alone = count_nodes(nodes_at(alone, GetParam()), 0, 1e3);
  for (const Table& table : {Table{"a sheet", 2, 2, 2}, Table{"a box", 2, 2, 25}, Table{"near", 4, 2, 25},
                             Table{"a solid one", 3, 12, 12}}) {
    const auto in_table = [&](double x, double y) {
      const double depth = y - kBack - table.gap;
      const bool inside = depth >= 0 && depth < table.thickness && x > 5 && x < 235;
      return inside && (depth < table.sheet || depth >= table.thickness - table.sheet || x < 7 || x > 233);
    };
    const CtVolume ct = painted([&](double x, double y, double) { return in_body(x, y) || in_table(x, y); });
    const BodyNodes nodes = nodes_at(ct, GetParam());
    EXPECT_EQ(count_nodes(nodes, kBack + table.gap + 0.5 * GetParam(), 1e3), 0u) << table.name;
    const double remaining =
        double(count_nodes(nodes, 0, 1e3));  // some of the rim is removed with a table 2 mm away
    EXPECT_NEAR(remaining, double(nodes_alone), 0.004 * double(nodes_alone)) << table.name;
  }
}

// No node lies in a sheet that touches the body.
TEST_P(BehindTheBody, TouchingSheetHasNoNodes) {
  const CtVolume ct = painted([](double x, double y, double) {
    return in_body(x, y) || (y >= kBack && y < kBack + 2 && x > 5 && x < 235);
  });
  const BodyNodes nodes = nodes_at(ct, GetParam());
  EXPECT_EQ(count_nodes(nodes, kBack + 2, 1e3), 0u);
}

// A light pad that follows the back, and touches it here and there, leaves no ridges behind the body, and the
// back has no pits.
TEST_P(BehindTheBody, PadLeavesNoRidges) {
  const auto pad = [](double x, double y, double z) {
    const double depth = y - kBack - 2 - 2 * std::sin(x / 9) * std::cos(z / 13);
    return depth >= 0 && depth < 6 && x > 5 && x < 235;
  };
  CtVolume ct = painted([](double x, double y, double) { return in_body(x, y); });
  const std::size_t alone = count_nodes(nodes_at(ct, GetParam()), 0, 1e3);
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++)
        if (ct.at(i, j, k) < -500 && pad(i, j, k)) ct.at(i, j, k) = -330;
  const BodyNodes nodes = nodes_at(ct, GetParam());
  EXPECT_EQ(count_nodes(nodes, kBack + 3 + 0.5 * GetParam(), 1e3), 0u);
  EXPECT_GE(double(count_nodes(nodes, 0, 1e3)), 0.999 * double(alone));
}

// Thin parts of the body, such as ears and fingers, do not count as surroundings.
TEST(Surroundings, EarsAndFingersRemain) {
  const auto finger = [](double x, double y, double z) {  // 60 mm long, 5 mm thick, at the body's front
    return std::abs(x - 120) < 2.5 && std::abs(z - 30) < 2.5 && y < 20 && y > -40;
  };
  const auto moved_body = [](double x, double y) { return in_body(x, y - 60); };
  const CtVolume ct =
      painted([&](double x, double y, double z) { return moved_body(x, y) || finger(x, y - 60, z); });
  const Surroundings beside = find_surroundings(Exec(2), ct, -449);
  EXPECT_EQ(std::count(beside.mask.begin(), beside.mask.end(), 1), 0);
}

// The vessels of a lung belong to the body.
TEST(Surroundings, LungVesselsBelongToBody) {
  const CtVolume ct = painted([](double x, double y, double z) {
    const double u = (x - 120) / 75, v = (y - 65) / 40;
    const bool in_lung = u * u + v * v < 1;
    const bool in_vessel = std::hypot(y - 65, z - 30) < 1.5;  // 150 mm long
    return in_body(x, y) && (!in_lung || in_vessel);
  });
  const Surroundings beside = find_surroundings(Exec(2), ct, -449);
  EXPECT_EQ(std::count(beside.mask.begin(), beside.mask.end(), 1), 0);
}

// One and four threads find the same surroundings.
TEST(Surroundings, EqualMaskOnAnyThreads) {
  const CtVolume ct =
      painted([](double x, double y, double) { return in_body(x, y) || (y > 123 && y < 126); });
  const Surroundings one = find_surroundings(Exec(1), ct, -449), four = find_surroundings(Exec(4), ct, -449);
  EXPECT_GT(std::count(one.mask.begin(), one.mask.end(), 1), 0);
  EXPECT_EQ(one.mask, four.mask);
  EXPECT_EQ(one.row_mask, four.row_mask);
}

}  // namespace
}  // namespace turgor::lattice
