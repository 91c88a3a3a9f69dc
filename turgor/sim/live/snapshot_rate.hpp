// Rate at which a session publishes snapshots for its reader while the world plays.
#pragma once

#include <algorithm>
#include <chrono>

namespace turgor {

/// Decides after each frame whether its snapshot is published. A snapshot that no reader has taken yet is
/// replaced at most 30 times per second, since drawing the surface takes as long as a step. While frames are
/// late, there are at most 16 snapshots per second, so that they and their pictures leave time for frames,
/// and one that no reader has taken is replaced ten times per second. The 16 are due at a fixed rate: one
/// that waits for the end of a frame does not delay those after it.
struct SnapshotRate {
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kUnread{33}, kUnreadLate{100};
  static constexpr std::chrono::microseconds kLate{62500};

  Time published_at = {};  // of the latest snapshot
  Time due_late = {};      // of the next one while frames are late

  /// True if the snapshot of a frame is due. `is_unread`: the latest one was not taken yet.
  bool is_due(Time now, bool is_late, bool is_unread) const {
    if (is_unread && now - published_at < (is_late ? kUnreadLate : kUnread)) return false;
    return !is_late || now >= due_late;
  }
  /// Counts a snapshot that was published for a frame that ended at `now`. The next one is due within kLate,
  /// however many were published while frames were in time.
  void count(Time now) { due_late = std::clamp(due_late, now - kLate, now) + kLate; }
};

}  // namespace turgor
