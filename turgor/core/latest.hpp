// latest<T>: one thread writes values, one other thread reads the newest complete value. Neither ever waits
// (triple buffering). The writer and the reader own a slot each and exchange it with the third, which holds
// the newest value.
#pragma once

#include <atomic>
#include <cstdint>

namespace turgor {

template <class T>
class latest {  // NOLINT(readability-identifier-naming): reads as a word in declarations, like std::atomic
 public:
  latest() = default;
  explicit latest(const T& first) : slots_{first, first, first} {}
  /// No other thread may access either object meanwhile.
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

  /// Writer thread only.
  void write(const T& value) {
    writing() = value;
    publish();
  }
  /// Writes in place, for values that keep their memory: overwrite all of writing(), which holds an older
  /// value, then publish.
  T& writing() { return slots_[writing_]; }
  void publish() {
    writing_ =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kSlot;
  }

  /// Newest value (reader thread only). The reference stays valid until the next read.
  const T& read() {
    if (has_news()) reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kSlot;
    return slots_[reading_];
  }
  /// True if a value was published since the last read.
  bool has_news() const { return (middle_.load(std::memory_order_relaxed) & kFresh) != 0; }

 private:
  static constexpr std::uint8_t kSlot = 3, kFresh = 4;
  T slots_[3]{};
  std::uint8_t writing_ = 0;
  std::atomic<std::uint8_t> middle_{1};
  std::uint8_t reading_ = 2;
};

}  // namespace turgor
