#include "turgor/sim/report/require.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

const Json kReport = {{"haptics", {{"missed", 0.002}}},
                      {"tools", {{{"name", "finger"}, {"force_max_N", 0.4}}, {{"name", "hook"}}}},
                      {"frames", {3, 4}}};

std::string missed(const std::string& text) { return missed_by(kReport, *read_requirement(text)).value(); }

// A value within its bound yields no message.
TEST(Require, ValueWithinBoundPasses) {
  for (const char* text :
       {"haptics.missed<0.01", "haptics.missed<=0.002", "haptics.missed>0.001", "haptics.missed>=2e-3",
        "tools.finger.force_max_N<1", "tools.0.force_max_N>0", "frames.1>=4"})
    EXPECT_EQ(missed(text), "") << text;
}

// A missed bound yields a message with the value.
TEST(Require, MissedBoundReportsValue) {
  EXPECT_EQ(missed("haptics.missed<0.001"), "required haptics.missed<0.001, found 0.002");
  EXPECT_NE(missed("haptics.missed<0.002"), "");
  EXPECT_NE(missed("tools.finger.force_max_N>0.4"), "");
}

// Invalid requirements and keys without a number are errors.
TEST(Require, RejectsInvalidRequirements) {
  for (const char* text :
       {"", "<3", "haptics.missed", "haptics.missed<", "haptics.missed<x", "a<1 ", "a<nan", "a<inf", "a=3"})
    EXPECT_FALSE(read_requirement(text)) << text;
  for (const char* text : {"haptics<1", "haptics.no<1", "tools.2.force_max_N<1", "tools.hook.force_max_N<1",
                           "tools.-1<1", "x.y.z<1"})
    EXPECT_FALSE(missed_by(kReport, *read_requirement(text))) << text;
}

}  // namespace
}  // namespace turgor
