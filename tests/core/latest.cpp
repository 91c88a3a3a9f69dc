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

TEST(latest, the_reader_sees_the_newest_value_written) {
  latest<int> value(7);
  EXPECT_EQ(value.read(), 7);
  value.write(8);
  value.write(9);
  EXPECT_EQ(value.read(), 9);
  EXPECT_EQ(value.read(), 9);
}

TEST(latest, values_arrive_whole_and_in_order_between_two_threads) {
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

TEST(latest, filled_in_place_it_keeps_its_memory_and_says_when_it_is_new) {
  latest<std::vector<int>> values;
  std::vector<const int*> memory;
  for (int i = 0; i < 9; i++) {
    values.writing().assign(100, i);
    memory.push_back(values.writing().data());
    EXPECT_FALSE(values.has_news()) << "not before it is published";
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
