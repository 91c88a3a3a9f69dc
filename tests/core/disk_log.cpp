#include "turgor/core/disk_log.hpp"

#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/small_disk.hpp"

namespace turgor {
namespace {

struct Entry {
  std::size_t number = 0;
  double more[7] = {};
};
Entry entry(std::size_t n) { return {n, {0.5 * double(n)}}; }

/// Memory of this process that no file backs [bytes].
std::size_t anonymous_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return 1024 * std::stoul(line.substr(8));
  return 0;
}

void expect_numbers(const DiskLog<Entry>& log, std::size_t count) {
  ASSERT_EQ(log.size(), count);
  std::size_t n = 0;
  for (const Entry& e : log) {
    ASSERT_EQ(e.number, n);
    ASSERT_EQ(e.more[0], 0.5 * double(n));
    n++;
  }
  EXPECT_EQ(n, count);
}

// Entries on disk and in memory are one sequence, also in a copy that is taken while the log grows.
TEST(DiskLog, EntriesStayInOrder) {
  DiskLog<Entry> log, before;
  for (std::size_t n = 0; n < 50; n++) log.append(entry(n));
  log.limit_memory(100000, 256);
  for (std::size_t n = 50; n < 10000; n++) {
    log.append(entry(n));
    ASSERT_EQ(log.back().number, n);
    if (n % 77 == 0) log.save();
    if (n == 5000) before = log;
  }
  EXPECT_EQ(log.in_memory(), 256u);
  EXPECT_EQ(log.missed(), 0u);
  expect_numbers(log, 10000);
  expect_numbers(before, 5001);
  const DiskLog<Entry> moved = std::move(log);
  expect_numbers(moved, 10000);
  EXPECT_EQ(std::count_if(moved.begin(), moved.end(), [](const Entry& e) { return e.number % 2 == 0; }),
            5000);
  EXPECT_EQ((moved.end() - 1)->number, 9999u);
}

// An hour of ticks at 1 kHz needs no more memory than what is kept in memory.
TEST(DiskLog, MemoryStaysBounded) {
  constexpr std::size_t kHour = 3600 * 1000, kInMemory = 16384;  // 230 MB in all, 1 MB in memory
  DiskLog<Entry> log;
  log.limit_memory(kHour, kInMemory);
  const std::size_t before = anonymous_memory();
  for (std::size_t n = 0; n < kHour; n++) {
    log.append(entry(n));
    if (n % 16 == 0) log.save();
  }
  EXPECT_LT(anonymous_memory(), before + (4u << 20));
  EXPECT_EQ(log.size(), kHour);
  EXPECT_EQ(log.missed(), 0u);
  for (std::size_t n = 0; n < kHour; n += 9973) ASSERT_EQ(log[n].number, n);
}

// A log that is not saved in time, or that reached its limit, counts what it cannot keep.
TEST(DiskLog, FullLogCountsMissedEntries) {
  DiskLog<Entry> log;
  log.limit_memory(1000, 64);
  for (std::size_t n = 0; n < 100; n++) log.append(entry(n));
  EXPECT_EQ(log.missed(), 36u);
  expect_numbers(log, 64);
  log.save();
  for (std::size_t n = 64; n < 1200; n++) log.append(entry(n)), log.save();
  EXPECT_EQ(log.missed(), 236u);
  expect_numbers(log, 1000);
}

// A log that fits in memory uses no disk.
TEST(DiskLog, ShortLogNeedsNoDisk) {
  DiskLog<Entry> log;
  log.limit_memory(64, 64);
  for (std::size_t n = 0; n < 100; n++) log.append(entry(n)), log.save();
  EXPECT_EQ(log.missed(), 36u);
  expect_numbers(log, 64);
}

// A log on disk that gets a limit which fits in memory is read back, and grows there.
TEST(DiskLog, ShorterLimitReadsEntriesBack) {
  DiskLog<Entry> log;
  log.limit_memory(1000, 16);
  for (std::size_t n = 0; n < 50; n++) log.append(entry(n)), log.save();
  const DiskLog<Entry> before = log;
  log.limit_memory(80, 128);
  EXPECT_EQ(log.in_memory(), 50u);
  for (std::size_t n = 50; n < 100; n++) log.append(entry(n)), log.save();
  EXPECT_EQ(log.missed(), 20u);
  expect_numbers(log, 80);
  expect_numbers(before, 50);
}

// On a full disk the log keeps what it has and counts the rest.
TEST(DiskLog, FullDiskLosesNoEarlierEntry) {
  EXPECT_TRUE(test::on_a_small_disk(100 * sizeof(Entry) + 7, [] {
    DiskLog<Entry> log;
    log.limit_memory(1000, 64);
    for (std::size_t n = 0; n < 1000; n++) log.append(entry(n)), log.save();
    bool is_ordered = log.size() > 64 && log.size() <= 164 && log.size() + log.missed() == 1000;
    for (std::size_t n = 0; n < log.size(); n++) is_ordered = is_ordered && log[n].number == n;
    return is_ordered;
  }));
}

// One thread appends while another one saves.
TEST(DiskLog, SavesWhileOtherThreadAppends) {
  constexpr std::size_t kCount = 300000;
  DiskLog<Entry> log;
  log.limit_memory(kCount, 4096);
  std::thread appending([&log] {
    for (std::size_t n = 0; n < kCount;) {
      const std::size_t missed = log.missed();
      log.append(entry(n));
      if (log.missed() == missed) n++;
    }
  });
  while (log.size() < kCount) log.save();
  appending.join();
  expect_numbers(log, kCount);
}

}  // namespace
}  // namespace turgor
