#include "turgor/sim/scene/nearest_name.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// The edit distance counts insertions, deletions, replacements and swaps of neighbors.
TEST(NearestName, EditDistance) {
  EXPECT_EQ(edit_distance("tension", "tension"), 0);
  EXPECT_EQ(edit_distance("tensoin", "tension"), 1);  // two neighbors swapped
  EXPECT_EQ(edit_distance("tenson", "tension"), 1);   // one missing
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

// The nearest name is found; a dissimilar name has none.
TEST(NearestName, FindsSimilarName) {
  const std::vector<std::string> names = {"duration", "gravity", "frame_rate"};
  EXPECT_EQ(nearest_name("gravty", names), "gravity");
  EXPECT_EQ(nearest_name("framerate", names), "frame_rate");
  EXPECT_EQ(nearest_name("colour", names), "");
  EXPECT_EQ(nearest_name(std::string(100000, 'x'), names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

// The suggestion names the nearest name or lists all known ones.
TEST(NearestName, SuggestsOrListsNames) {
  EXPECT_EQ(suggestion("gravty", {"duration", "gravity"}), "; did you mean gravity?");
  EXPECT_EQ(suggestion("colour", {"duration", "gravity"}), "; known are duration and gravity");
  EXPECT_EQ(suggestion("colour", {"duration"}), "; known is duration");
}

}  // namespace
}  // namespace turgor
