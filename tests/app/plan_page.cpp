// Verdict and page of `turgor plan-excision`.
#include "app/plan_page.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// A wound that stays open needs more force than was found: it is not best beside wounds that close, and the
// page marks it. A direction that could not be simulated is neither best nor worst.
TEST(PlanPage, OpenWoundIsNotBest) {
  std::vector<PlannedDirection> found(4);
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
  for (PlannedDirection& direction : found) direction.is_closed = false;
  EXPECT_EQ(verdict_of(found).best, 1u);
}

// A plan in which no wound closes calls no direction best, neither in the sentence nor in the plot.
TEST(PlanPage, NothingIsBestWhereNothingCloses) {
  std::vector<PlannedDirection> found(3);
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

}  // namespace
}  // namespace turgor
