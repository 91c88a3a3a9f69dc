#include "turgor/view/transfer.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr TransferPoint kRamp[] = {{0, 0, {255, 0, 0}}, {100, 0.5f, {255, 0, 0}}, {200, 0.5f, {0, 0, 255}}};

// The mean over a range of values matches numerical integration.
TEST(Transfer, MeanIntegratesValueRange) {
  const Transfer transfer(kRamp);
  for (const auto& [a, b] : {std::pair{-50.0f, 150.0f}, {20.0f, 90.0f}, {180.0f, 30.0f}, {120.0f, 120.5f}}) {
    double extinction = 0, red = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; i++) {
      const float hu = a + (b - a) * (float(i) + 0.5f) / kSteps;
      const Optical point = transfer.mean(hu, hu);
      extinction += point.extinction / kSteps;
      red += point.extinction * point.color.x / kSteps;
    }
    const Optical mean = transfer.mean(a, b);
    EXPECT_NEAR(mean.extinction, extinction, 0.01 * extinction);
    EXPECT_NEAR(mean.color.x, red / extinction, 0.01);
  }
}

// The opacity of a transfer point applies per millimeter.
TEST(Transfer, OpacityIsPerMillimeter) {
  const Transfer transfer(kRamp);
  EXPECT_NEAR(1 - std::exp(-transfer.mean(150, 150).extinction * 0.001f), 0.5, 1e-4);
  EXPECT_NEAR(1 - std::exp(-transfer.mean(9000, 9000).extinction * 0.001f), 0.5, 1e-4);
  EXPECT_EQ(transfer.mean(-20, -5).extinction, 0);
}

// A range is visible if it contains a visible value.
TEST(Transfer, RangeVisibleIfItContainsVisibleValue) {
  const Transfer transfer(kRamp);
  EXPECT_FALSE(transfer.is_visible(-1000, 0));
  EXPECT_TRUE(transfer.is_visible(-1000, 1));
  EXPECT_TRUE(transfer.is_visible(30000, 32767));
  EXPECT_FALSE(transfer.is_visible(-32768, -30000));
}

// The largest extinction of a range matches an exhaustive search.
TEST(Transfer, MostExtinctionIsRangeMaximum) {
  for (const std::string& preset : volume_presets()) {
    const Transfer transfer(transfer_points(preset));
    for (const auto& [low, high] :
         {std::pair{-1000, -990}, {-960, -400}, {-500, 200}, {-30000, 30000}, {7, 7}}) {
      float most = 0;
      for (int hu = low; hu <= high; hu++) most = std::max(most, transfer.extinction(hu));
      EXPECT_EQ(transfer.most_extinction(low, high), most) << preset << " " << low << " " << high;
    }
  }
}

// Presets have increasing values and opacities below one.
TEST(Transfer, PresetsAreValid) {
  ASSERT_EQ(volume_presets(), (std::vector<std::string>{"skin", "soft tissue", "muscle", "bone", "lung"}));
  for (const std::string& preset : volume_presets()) {
    const auto points = transfer_points(preset);
    ASSERT_GE(points.size(), 2u) << preset;
    EXPECT_EQ(points.front().opacity, 0) << preset << ": air must be invisible";
    for (std::size_t i = 0; i < points.size(); i++) {
      EXPECT_LT(points[i].opacity, 1) << preset;
      if (i > 0) {
        EXPECT_GT(points[i].hu, points[i - 1].hu) << preset;
      }
    }
  }
  EXPECT_TRUE(transfer_points("spleen").empty());
}

// Presets show their tissue and hide air.
TEST(Transfer, PresetsShowTissueAndHideAir) {
  const std::pair<const char*, int> tissues[] = {
      {"skin", 40}, {"soft tissue", 60}, {"muscle", 60}, {"bone", 700}, {"lung", -850}};
  for (const auto& [preset, hu] : tissues) {
    const Transfer transfer(transfer_points(preset));
    EXPECT_GT(transfer.extinction(hu), 0) << preset;
    EXPECT_EQ(transfer.extinction(-1000), 0) << preset;
  }
  EXPECT_EQ(Transfer(transfer_points("bone")).extinction(60), 0);
}

}  // namespace
}  // namespace turgor
