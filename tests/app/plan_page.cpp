// Verdict and page of `turgor plan-excision`.
#include "app/plan_page.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// A wound that stays open needs more force than was found: it is not best beside wounds that close, and the
// page marks it. A direction that could not be simulated is neither best nor worst.
TEST(PlanPage, OpenWoundIsNotBest) {
  std::vector<PlannedExcision> found(4);
  constexpr double kForces[] = {9.0, 8.9, 9.6, 9.2};
  for (std::size_t n = 0; n < 4; n++)
    found[n].angle = 45.0 * double(n), found[n].closing_force = kForces[n], found[n].is_closed = n != 1;
  const PlanVerdict verdict = verdict_of(found);
  EXPECT_EQ(verdict.best, 0u);
  EXPECT_EQ(verdict.worst, 2u);
  EXPECT_NE(verdict.sentence.find("in 1 of 4 directions"), std::string::npos) << verdict.sentence;
  EXPECT_NE(plan_page("mole", found, verdict).find("(open)"), std::string::npos);
  found[0].problem = "the piece is connected";
  EXPECT_EQ(verdict_of(found).best, 3u);
  // without a wound that closes, the least force counts
  for (PlannedExcision& direction : found) direction.is_closed = false;
  EXPECT_EQ(verdict_of(found).best, 1u);
}

// A plan in which no wound closes calls no direction best, neither in the sentence nor in the plot.
TEST(PlanPage, NothingIsBestWhereNothingCloses) {
  std::vector<PlannedExcision> found(3);
  for (std::size_t n = 0; n < 3; n++)
    found[n].angle = 60.0 * double(n), found[n].closing_force = 9.0 + double(n);
  const PlanVerdict open = verdict_of(found);
  EXPECT_FALSE(open.has_closed);
  EXPECT_NE(open.sentence.find("stays open in every direction, under 9.00 to 11.00 N"), std::string::npos)
      << open.sentence;
  EXPECT_EQ(polar_svg(found, open).find("stroke-dasharray"), std::string::npos);
  // a direction that closes is filled, the others are hollow
  found[2].is_closed = true;
  const std::string svg = polar_svg(found, verdict_of(found));
  EXPECT_NE(svg.find("stroke-dasharray"), std::string::npos);
  EXPECT_NE(svg.find("fill=\"#ffffff\""), std::string::npos);
}

// Lenses of several ratios have a curve each, with its ratio, and the sentence names the best one.
TEST(PlanPage, ShapesHaveCurvesOfTheirOwn) {
  std::vector<PlannedExcision> found;
  for (const double length : {0.04, 0.06})
    for (const double angle : {0.0, 90.0})
      found.push_back({.length = length,
                       .width = 0.02,
                       .angle = angle,
                       .closing_force = 100 * length + angle / 90,
                       .stretch = 1.1 + length,
                       .is_closed = true});
  const PlanVerdict verdict = verdict_of(found);
  EXPECT_EQ(verdict.best, 0u);
  EXPECT_EQ(verdict.worst, 3u);
  EXPECT_NE(verdict.sentence.find("0 degrees with a ratio of 2: 4.00 N"), std::string::npos)
      << verdict.sentence;
  const std::string svg = polar_svg(found, verdict);
  EXPECT_NE(svg.find("length/width 3<"), std::string::npos);
  std::size_t curves = 0;
  for (std::size_t at = svg.find("<polygon"); at != std::string::npos; at = svg.find("<polygon", at + 1))
    curves++;
  EXPECT_EQ(curves, 2u);
  EXPECT_NE(plan_page("mole", found, verdict).find("<td>1.160</td>"), std::string::npos);
}

}  // namespace
}  // namespace turgor
