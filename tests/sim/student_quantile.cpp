#include "turgor/sim/student_quantile.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Values of the printed table of the two-sided 95 % quantile for 1 to 30 degrees of freedom and more.
TEST(StudentQuantile, EqualsPrintedTable) {
  constexpr double kTable[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                               2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                               2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
  for (int freedom = 1; freedom <= 30; freedom++)
    EXPECT_NEAR(student_quantile(freedom), kTable[freedom - 1], 1e-3) << freedom;
  EXPECT_NEAR(student_quantile(60), 2.0003, 1e-4);
  EXPECT_NEAR(student_quantile(120), 1.9799, 1e-4);
  EXPECT_NEAR(student_quantile(1'000'000), 1.95997, 1e-5);
}

// The sum and the expansion agree where one replaces the other.
TEST(StudentQuantile, FallsAcrossChangeOfMethod) {
  const double step = student_quantile(199) - student_quantile(200);
  EXPECT_GT(step, 0);
  EXPECT_NEAR(step, student_quantile(200) - student_quantile(201), 2e-6);
}

}  // namespace
}  // namespace turgor
