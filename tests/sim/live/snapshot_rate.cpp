#include "turgor/sim/live/snapshot_rate.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

using std::chrono::milliseconds;

/// A session whose frames take the same time each. Counts snapshots and the longest time between two.
struct RatedFrames {
  SnapshotRate rate = {};
  SnapshotRate::Time now{std::chrono::hours(1)};
  int snapshots = 0;
  SnapshotRate::Time::duration longest{};

  void play(int frames, milliseconds period, bool is_late, bool is_unread = false) {
    for (int frame = 0; frame < frames; frame++) {
      now += period;
      if (!rate.is_due(now, is_late, is_unread)) continue;
      longest = std::max(longest, now - rate.published_at);
      rate.count(now), rate.published_at = now, snapshots++;
    }
  }
};

// Frames that become late after a minute in time show their states as soon as frames that were always late.
TEST(SnapshotRate, LateFramesAreShownAfterFramesInTime) {
  RatedFrames session;
  session.play(60 * 60, milliseconds(16), false);
  EXPECT_EQ(session.snapshots, 60 * 60);
  session.longest = {}, session.snapshots = 0;
  session.play(100, milliseconds(20), true);
  EXPECT_LE(session.longest, milliseconds(80));
  EXPECT_NEAR(session.snapshots, 2 / 0.0625, 2);
}

// Late frames of 20 ms give 16 snapshots a second, although 62.5 ms are no multiple of 20 ms.
TEST(SnapshotRate, LateFramesAreShownSixteenTimesPerSecond) {
  RatedFrames session;
  session.play(1, milliseconds(20), true);
  session.snapshots = 0;
  session.play(500, milliseconds(20), true);
  EXPECT_NEAR(session.snapshots, 160, 1);
}

// A snapshot that no reader takes is replaced 30 times per second, and ten times while frames are late.
TEST(SnapshotRate, UnreadSnapshotsAreReplacedLessOften) {
  RatedFrames session;
  session.play(1000, milliseconds(1), false, true);
  EXPECT_NEAR(session.snapshots, 30, 1);
  session.snapshots = 0;
  session.play(1000, milliseconds(1), true, true);
  EXPECT_NEAR(session.snapshots, 10, 1);
}

}  // namespace
}  // namespace turgor
