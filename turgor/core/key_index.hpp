// Index from 64-bit keys to consecutive numbers 0, 1, 2, … in order of first insertion. A hash table with
// open addressing and linear probing. Keys are below 2⁶⁴ − 1.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "turgor/core/config.hpp"

namespace turgor {

struct KeyEntry {
  std::uint64_t key = 0;
  int value = -1;
};

/// Read-only view of an index's table, in host or device memory. Its size is a power of two, or zero.
struct KeyTable {
  const KeyEntry* entries = nullptr;
  std::size_t size = 0;

  /// Slot of a key, or the free slot where it would be inserted.
  TURGOR_HD std::size_t slot(std::uint64_t key) const {
    std::size_t at = (key * 0x9e3779b97f4a7c15ull) >> 20 & (size - 1);
    while (entries[at].value >= 0 && entries[at].key != key) at = (at + 1) & (size - 1);
    return at;
  }
  /// Number of a key; -1 if unknown.
  TURGOR_HD int find(std::uint64_t key) const { return size == 0 ? -1 : entries[slot(key)].value; }
};

class KeyIndex {
 public:
  int find_or_add(std::uint64_t key) {
    if (2 * (keys_ + 1) > table_.size()) grow();
    KeyEntry& entry = table_[table().slot(key)];
    if (entry.value < 0) entry = {key, int(keys_++)};
    return entry.value;
  }
  /// Number of a key; -1 if unknown.
  int find(std::uint64_t key) const { return table().find(key); }
  std::size_t size() const { return keys_; }
  KeyTable table() const { return {table_.data(), table_.size()}; }
  const std::vector<KeyEntry>& entries() const { return table_; }

 private:
  void grow() {
    std::vector<KeyEntry> old(std::max<std::size_t>(1024, 2 * table_.size()));
    old.swap(table_);
    for (const KeyEntry& entry : old)
      if (entry.value >= 0) table_[table().slot(entry.key)] = entry;
  }
  std::vector<KeyEntry> table_;
  std::size_t keys_ = 0;
};

}  // namespace turgor
