#include "turgor/sim/scene/nearest_name.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(NearestName, DistanceCountsTypingSlips) {
  EXPECT_EQ(edit_distance("tension", "tension"), 0);
  EXPECT_EQ(edit_distance("tensoin", "tension"), 1);  // two neighbours swapped
  EXPECT_EQ(edit_distance("tenson", "tension"), 1);   // one left out
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(NearestName, FindsTheOneThatWasMeantAndNothingWhenNoneWas) {
  const std::vector<std::string> names = {"duration", "gravity", "frame_rate"};
  EXPECT_EQ(nearest_name("gravty", names), "gravity");
  EXPECT_EQ(nearest_name("framerate", names), "frame_rate");
  EXPECT_EQ(nearest_name("colour", names), "");
  EXPECT_EQ(nearest_name(std::string(100000, 'x'), names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(NearestName, SuggestsOrListsWhatIsKnown) {
  EXPECT_EQ(suggestion("gravty", {"duration", "gravity"}), "; did you mean gravity?");
  EXPECT_EQ(suggestion("colour", {"duration", "gravity"}), "; known are duration and gravity");
  EXPECT_EQ(suggestion("colour", {"duration"}), "; known is duration");
}

}  // namespace
}  // namespace turgor
