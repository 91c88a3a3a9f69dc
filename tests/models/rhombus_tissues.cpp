#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "turgor/models/rhombus/tissues.hpp"

namespace turgor::rhombus {
namespace {

TEST(RhombusTissues, the_first_is_the_liver_of_the_paper) {
  const ChainParams& liver = tissues()[0].chain;
  EXPECT_STREQ(tissues()[0].name, "liver");
  EXPECT_EQ(liver.normal, 1.5);
  EXPECT_EQ(liver.tangential, 1.8);
  EXPECT_EQ(liver.decay, 2);
  EXPECT_EQ(liver.boundary, 0.05);
}

TEST(RhombusTissues, every_one_builds_a_chain_and_names_its_source) {
  for (const Tissue& tissue : tissues()) {
    EXPECT_TRUE(build_chain(tissue.chain)) << tissue.name;
    EXPECT_GT(std::string(tissue.source).size(), 20u);
    EXPECT_EQ(find_tissue(tissue.name), &tissue);
  }
  EXPECT_EQ(find_tissue("no tissue"), nullptr);
}

TEST(RhombusTissues, those_with_a_modulus_answer_like_hertz_within_5_percent_of_the_peak) {
  for (const Tissue& tissue : tissues()) {
    if (tissue.young == 0) continue;
    const Chain chain = *build_chain(tissue.chain);
    const auto hertz = [&](double d) {
      return 16.0 / 9 * tissue.young * std::sqrt(0.005) * std::pow(d, 1.5);
    };
    double worst = 0;
    for (double d = 0; d <= 0.01; d += 1e-4)
      worst = std::max(worst, std::abs(force_of_depth(chain, d) - hertz(d)) / hertz(0.01));
    std::printf("%s: %.3f N at 10 mm, largest residual %.1f %%\n", tissue.name, force_of_depth(chain, 0.01),
                100 * worst);
    EXPECT_LT(worst, 0.05) << tissue.name;
  }
}

}  // namespace
}  // namespace turgor::rhombus
