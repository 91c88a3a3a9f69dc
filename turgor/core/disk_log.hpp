// Log that one thread appends to at a fixed rate and that another thread moves to disk, so that an hour of
// ticks needs no more memory than a minute. The disk part is a temporary file without a name: it disappears
// with the process.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "turgor/core/assert.hpp"

namespace turgor {

/// Temporary file that grows at its end and is read as memory.
class TemporaryFile {
 public:
  /// For at most this many bytes. Null if no folder for temporary files ($TMPDIR, /var/tmp) can be used.
  static std::shared_ptr<TemporaryFile> create(std::size_t most);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  /// False if the disk is full; the file then keeps its length.
  bool append(const void* bytes, std::size_t size);
  std::size_t size() const { return size_; }
  const std::byte* bytes() const { return bytes_; }

 private:
  TemporaryFile(int descriptor, const std::byte* bytes, std::size_t most)
      : descriptor_(descriptor), bytes_(bytes), most_(most) {}

  int descriptor_;
  const std::byte* bytes_;  // read-only mapping of the file and of its future growth
  std::size_t most_, size_ = 0;
};

/// Sequence of up to a limit of entries. Without limit_memory it is a vector. Copies share what is on disk.
template <class T>
class DiskLog {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  DiskLog() = default;
  DiskLog(std::initializer_list<T> entries) : memory_(entries), count_(entries.size()) {}
  DiskLog(const DiskLog&) = default;
  DiskLog(DiskLog&& other) noexcept
      : memory_(std::move(other.memory_)),
        file_(std::move(other.file_)),
        most_(other.most_),
        count_(other.count_.take()),
        saved_(other.saved_.take()),
        missed_(other.missed_.take()) {}
  DiskLog& operator=(const DiskLog&) = default;
  DiskLog& operator=(DiskLog&& other) noexcept {
    DiskLog moved(std::move(other));
    memory_.swap(moved.memory_), file_.swap(moved.file_);
    most_ = moved.most_, count_ = moved.count_, saved_ = moved.saved_, missed_ = moved.missed_;
    return *this;
  }
  ~DiskLog() = default;

  /// Sets the largest number of entries; all of them are in memory.
  void limit(std::size_t most) { most_ = most; }
  /// Sets the largest number of entries. Afterwards append neither allocates nor writes, and save keeps
  /// `in_memory` entries in memory.
  void limit_memory(std::size_t most, std::size_t in_memory);
  /// Appends an entry. A full log only counts it as missed: the limit is reached, or save was not called for
  /// `in_memory` entries.
  void append(const T& entry);
  /// Moves entries to disk; concurrently with append, from one other thread.
  void save();

  std::size_t missed() const { return missed_.value; }
  std::size_t size() const { return count_.value.load(std::memory_order_acquire); }
  std::size_t in_memory() const { return memory_.size(); }
  bool empty() const { return size() == 0; }
  const T& operator[](std::size_t index) const {
    TURGOR_ASSERT(index < size(), "an entry is in the log");
    if (!file_) return memory_[index];
    return index < saved_.value ? on_disk()[index] : memory_[index % memory_.size()];
  }
  /// Newest entry; never on disk only.
  const T& back() const {
    TURGOR_ASSERT(!empty(), "the log has an entry");
    return memory_[file_ ? (size() - 1) % memory_.size() : size() - 1];
  }

  class Iterator {
   public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using pointer = const T*;
    using reference = const T&;

    Iterator() = default;
    Iterator(const DiskLog* log, std::size_t index) : log_(log), index_(index) {}
    const T& operator*() const { return (*log_)[index_]; }
    const T* operator->() const { return &(*log_)[index_]; }
    const T& operator[](std::ptrdiff_t n) const { return *(*this + n); }
    Iterator& operator+=(std::ptrdiff_t n) { return index_ += std::size_t(n), *this; }
    Iterator& operator-=(std::ptrdiff_t n) { return *this += -n; }
    Iterator& operator++() { return *this += 1; }
    Iterator& operator--() { return *this += -1; }
    Iterator operator++(int) { return ++*this - 1; }
    Iterator operator--(int) { return --*this + 1; }
    friend Iterator operator+(Iterator a, std::ptrdiff_t n) { return a += n; }
    friend Iterator operator+(std::ptrdiff_t n, Iterator a) { return a += n; }
    friend Iterator operator-(Iterator a, std::ptrdiff_t n) { return a -= n; }
    friend std::ptrdiff_t operator-(Iterator a, Iterator b) { return std::ptrdiff_t(a.index_ - b.index_); }
    friend bool operator==(Iterator a, Iterator b) { return a.index_ == b.index_; }
    friend auto operator<=>(Iterator a, Iterator b) { return a.index_ <=> b.index_; }

   private:
    const DiskLog* log_ = nullptr;
    std::size_t index_ = 0;
  };
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size()}; }

 private:
  /// Atomic number that can be copied; only its own thread writes it.
  struct Count {
    std::atomic<std::size_t> value = 0;
    Count() = default;
    explicit Count(std::size_t n) : value(n) {}
    Count(const Count& other) : value(other.value.load()) {}
    Count& operator=(const Count& other) { return value = other.value.load(), *this; }
    std::size_t take() { return value.exchange(0); }
  };

  /// Reads entries back from the disk, and makes room for all of them.
  void keep_in_memory();
  const T* on_disk() const { return reinterpret_cast<const T*>(file_->bytes()); }
  bool write(std::size_t first, std::size_t end);

  std::vector<T> memory_;                // with a file: ring of the newest entries, entry n at n mod its size
  std::shared_ptr<TemporaryFile> file_;  // entries 0 to saved_
  std::size_t most_ = std::size_t(-1);
  Count count_, saved_, missed_;  // of the appending, of the saving and of the appending thread
};

template <class T>
void DiskLog<T>::limit_memory(std::size_t most, std::size_t in_memory) {
  TURGOR_ASSERT(in_memory > 0, "the newest entry is in memory");
  most_ = most;
  std::shared_ptr<TemporaryFile> file =
      most > in_memory ? TemporaryFile::create(most * sizeof(T)) : std::shared_ptr<TemporaryFile>();
  if (!file) return keep_in_memory();

  // entries of an earlier session go to disk, and the newest ones into the ring
  const std::size_t before = std::min(size(), most);
  std::vector<T> ring(in_memory);
  for (std::size_t n = 0; n < before; n++) {
    ring[n % in_memory] = (*this)[n];
    const bool is_full = (n + 1) % in_memory == 0 || n + 1 == before;
    if (is_full && !file->append(ring.data(), (n % in_memory + 1) * sizeof(T))) return keep_in_memory();
  }
  memory_ = std::move(ring), file_ = std::move(file);
  count_.value = before, saved_.value = before;
}

template <class T>
void DiskLog<T>::keep_in_memory() {
  std::vector<T> all;
  all.reserve(most_);
  all.assign(begin(), end());
  memory_ = std::move(all), file_.reset(), saved_.value = 0;
}

template <class T>
void DiskLog<T>::append(const T& entry) {
  const std::size_t n = count_.value.load(std::memory_order_relaxed);
  const bool is_full =
      n >= most_ || (file_ && n - saved_.value.load(std::memory_order_acquire) >= memory_.size());
  if (is_full) {
    missed_.value++;
    return;
  }
  if (file_)
    memory_[n % memory_.size()] = entry;
  else
    memory_.push_back(entry);
  count_.value.store(n + 1, std::memory_order_release);
}

/// Writes neighboring entries of the ring.
template <class T>
bool DiskLog<T>::write(std::size_t first, std::size_t end) {
  if (first == end) return true;
  if (!file_->append(&memory_[first % memory_.size()], (end - first) * sizeof(T))) return false;
  saved_.value.store(end, std::memory_order_release);
  return true;
}

template <class T>
void DiskLog<T>::save() {
  if (!file_) return;
  const std::size_t first = saved_.value, end = size();
  if (end - first < memory_.size() / 8) return;  // few, large writes
  TURGOR_CHECK(file_->size() == first * sizeof(T), "only the newest copy of a log grows");
  const std::size_t turn = first - first % memory_.size() + memory_.size();  // where the ring begins again
  if (write(first, std::min(end, turn)) && end > turn) write(turn, end);
}

}  // namespace turgor
