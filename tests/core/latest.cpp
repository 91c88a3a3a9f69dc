#include "turgor/core/latest.hpp"

#include <array>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

struct Sample {
  long number = 0;
  std::array<long, 16> copies{};
};

Sample sample(long number) {
  Sample s{number, {}};
  s.copies.fill(number);
  return s;
}

// The reader gets the newest value written and gets it again until the next write.
TEST(Latest, ReaderGetsNewestValue) {
  latest<int> value(7);
  EXPECT_EQ(value.read(), 7);
  value.write(8);
  value.write(9);
  EXPECT_EQ(value.read(), 9);
  EXPECT_EQ(value.read(), 9);
}

// Values pass between two threads without tearing and never in reverse order.
TEST(Latest, TwoThreads_ValuesAreWholeAndOrdered) {
  latest<Sample> value;
  constexpr long kLast = 200000;
  std::thread writer([&] {
    for (long n = 1; n <= kLast; n++) value.write(sample(n));
  });
  long before = 0, torn = 0, backwards = 0;
  while (before < kLast) {
    const Sample& seen = value.read();
    for (const long copy : seen.copies) torn += copy != seen.number;
    backwards += seen.number < before;
    before = seen.number;
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
}

// Values that are filled in their slot reuse the memory of three slots; has_news reports unread values.
TEST(Latest, Publish_ReusesThreeSlots) {
  latest<std::vector<int>> values;
  std::vector<const int*> memory;
  for (int i = 0; i < 9; i++) {
    values.writing().assign(100, i);
    memory.push_back(values.writing().data());
    EXPECT_FALSE(values.has_news()) << "no news before publish()";
    values.publish();
    EXPECT_TRUE(values.has_news());
    EXPECT_EQ(values.read(), std::vector<int>(100, i));
    EXPECT_FALSE(values.has_news());
  }
  for (std::size_t i = 3; i < memory.size(); i++)
    EXPECT_EQ(memory[i], memory[i - 3]) << "three slots in turn";
}

}  // namespace
}  // namespace turgor
