// latest<T>: one thread writes whole values, one other thread reads the newest whole value. Neither ever
// waits. Three slots change hands: the writer's, the reader's, and the one in the middle that holds the
// newest value.
#pragma once

#include <atomic>
#include <cstdint>

namespace turgor {

template <class T>
class latest {  // NOLINT(readability-identifier-naming): reads as a word in declarations, like std::atomic
 public:
  latest() = default;
  explicit latest(const T& first) : slots_{first, first, first} {}
  /// While no other thread is at either of them.
  latest(const latest& other)
      : slots_{other.slots_[0], other.slots_[1], other.slots_[2]},
        writing_(other.writing_),
        middle_(other.middle_.load()),
        reading_(other.reading_) {}
  latest& operator=(const latest& other) {
    if (this == &other) return *this;
    for (int slot = 0; slot < 3; slot++) slots_[slot] = other.slots_[slot];
    writing_ = other.writing_, reading_ = other.reading_;
    middle_ = other.middle_.load();
    return *this;
  }

  /// Writer's thread only.
  void write(const T& value) {
    writing() = value;
    publish();
  }
  /// The same in place, for values that keep their memory: fill all of writing(), which holds some value of
  /// before, and publish it.
  T& writing() { return slots_[writing_]; }
  void publish() {
    writing_ =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kSlot;
  }

  /// Reader's thread only: the newest value. The reference stays valid until the next read.
  const T& read() {
    if (has_news()) reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kSlot;
    return slots_[reading_];
  }
  /// Has a value come since the last read?
  bool has_news() const { return (middle_.load(std::memory_order_relaxed) & kFresh) != 0; }

 private:
  static constexpr std::uint8_t kSlot = 3, kFresh = 4;
  T slots_[3]{};
  std::uint8_t writing_ = 0;
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t reading_ = 2;
};

}  // namespace turgor
