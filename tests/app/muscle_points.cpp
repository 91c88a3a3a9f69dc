// Quoted points of measured muscle and their labels.
#include "app/muscle_points.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Second series of the data set at 1 %/s to 30 %, by the labels that it has there.
constexpr StressPoint kLabeledAcross[] = {
    {5.6, 0.09733},  {11.77, 0.2032}, {19.06, 0.4315}, {23.62, 0.678}, {26.68, 0.9659}, {29.03, 1.265},
    {30.14, 1.424},  {31.62, 1.27},   {34.74, 1.104},  {41.09, 0.966}, {55.32, 0.8419}, {76.51, 0.7554},
    {101.9, 0.6948}, {150.4, 0.6264}, {206.1, 0.5805}, {249.6, 0.554}, {299.3, 0.5249}, {327, 0.5139}};
constexpr StressPoint kLabeledAlong[] = {
    {2.581, 0.07633}, {10.16, 0.2579}, {15.91, 0.4898}, {20.7, 0.7367}, {24.39, 1.04},  {27.48, 1.379},
    {29.2, 1.72},     {30.39, 1.844},  {32.18, 1.619},  {38.42, 1.394}, {52.61, 1.254}, {76.37, 1.156},
    {103.3, 1.087},   {157.2, 1.001},  {208.8, 0.9534}, {241.1, 0.93},  {279, 0.9068},  {330.2, 0.8747}};

/// Stress of a curve at a time between two of its points.
double stress_at(std::span<const StressPoint> curve, double time) {
  const auto after = std::find_if(curve.begin() + 1, curve.end() - 1,
                                  [time](const StressPoint& point) { return point.time >= time; });
  const auto before = after - 1;
  return before->stress +
         (after->stress - before->stress) * (time - before->time) / (after->time - before->time);
}

/// Root mean square of the difference between points and a curve, relative to the curve's peak.
double difference(std::span<const StressPoint> points, std::span<const StressPoint> curve) {
  double sum = 0, peak = 0;
  for (const StressPoint& point : points) sum += std::pow(stress_at(curve, point.time) - point.stress, 2);
  for (const StressPoint& point : curve) peak = std::max(peak, point.stress);
  return std::sqrt(sum / double(points.size())) / peak;
}

// Both series at 1 %/s are the same measurement with exchanged labels: each curve is the other series' curve
// of the other label within 5 % of the peak, and far from that of its own.
TEST(MusclePoints, SecondSeriesHasExchangedLabels) {
  EXPECT_LT(difference(kLabeledAcross, kAlongFast), 0.05);
  EXPECT_LT(difference(kLabeledAlong, kAcrossFast), 0.05);
  EXPECT_GT(difference(kLabeledAlong, kAlongFast), 0.15);
  EXPECT_GT(difference(kLabeledAcross, kAcrossFast), 0.15);
}

// The paper's stresses after a hold of 300 s: 0.61 ± 0.11 kPa along the fibers, 0.90 ± 0.05 kPa across.
TEST(MusclePoints, LabelsAgreeWithStressesOfPaper) {
  EXPECT_NEAR(std::end(kAlongSlow)[-1].stress, 0.61, 0.11);
  EXPECT_NEAR(std::end(kAlongFast)[-1].stress, 0.61, 0.11);
  EXPECT_NEAR(std::end(kAcrossSlow)[-1].stress, 0.90, 0.05);
  EXPECT_NEAR(std::end(kAcrossFast)[-1].stress, 0.90, 0.05);
}

}  // namespace
}  // namespace turgor
