#include "turgor/contact/permit_depth.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

contact::PairSite site_of(int node, double distance) {
  contact::PairSite site;
  site.node = node, site.distance = distance;
  return site;
}

// A node that is inside when it becomes a site stays there at first, and is let out over time. Other nodes
// keep their distances.
TEST(PermitDepth, OnlyNewDeepNodes_AreLetOutSlowly) {
  constexpr double kFrame = 0.01;
  std::vector<contact::PairSite> last{site_of(3, 0.001), site_of(7, -0.002)};
  std::vector<contact::PairSite> now{site_of(1, 0.004), site_of(3, -0.0005), site_of(5, -0.003),
                                     site_of(7, -0.002)};
  contact::permit_depth(last, kFrame, now);
  EXPECT_EQ(now[0].distance, 0.004);
  EXPECT_EQ(now[1].distance, -0.0005);
  EXPECT_EQ(now[2].distance, 0);
  EXPECT_EQ(now[3].distance, -0.002);
  // next frames: the permitted depth falls by 1/e in 0.2 s
  double permitted = 0.003;
  for (int frame = 0; frame < 20; frame++) {
    last = now;
    now[2] = site_of(5, -permitted);
    contact::permit_depth(last, kFrame, now);
    EXPECT_NEAR(now[2].distance, permitted * (std::exp(-0.05) - 1), 1e-12);
    permitted = now[2].permitted;
  }
  EXPECT_NEAR(permitted, 0.003 / std::exp(1), 1e-9);
  // never beyond the depth itself
  last = now;
  now[2] = site_of(5, -1e-5);
  contact::permit_depth(last, kFrame, now);
  EXPECT_EQ(now[2].distance, 0);
  EXPECT_EQ(now[2].permitted, 1e-5);
}

}  // namespace
}  // namespace turgor
