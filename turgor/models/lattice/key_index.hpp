// Numbers for keys: 0, 1, 2, … in the order of their first appearance. Open addressing; keys are below 2⁶⁴
// − 1.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "turgor/core/config.hpp"

namespace turgor::lattice {

struct KeyEntry {
  std::uint64_t key = 0;
  int value = -1;
};

/// The table of an index, on either side of a bus. Its size is a power of two, or nothing.
struct KeyTable {
  const KeyEntry* entries = nullptr;
  std::size_t size = 0;

  /// Where a key is, or where there is room for it.
  TURGOR_HD std::size_t place(std::uint64_t key) const {
    std::size_t at = (key * 0x9e3779b97f4a7c15ull) >> 20 & (size - 1);
    while (entries[at].value >= 0 && entries[at].key != key) at = (at + 1) & (size - 1);
    return at;
  }
  /// -1 = unknown.
  TURGOR_HD int find(std::uint64_t key) const { return size == 0 ? -1 : entries[place(key)].value; }
};

class KeyIndex {
 public:
  int find_or_add(std::uint64_t key) {
    if (2 * (keys_ + 1) > table_.size()) grow();
    KeyEntry& entry = table_[table().place(key)];
    if (entry.value < 0) entry = {key, int(keys_++)};
    return entry.value;
  }
  /// -1 = unknown.
  int find(std::uint64_t key) const { return table().find(key); }
  std::size_t size() const { return keys_; }
  KeyTable table() const { return {table_.data(), table_.size()}; }
  const std::vector<KeyEntry>& entries() const { return table_; }

 private:
  void grow() {
    std::vector<KeyEntry> old(std::max<std::size_t>(1024, 2 * table_.size()));
    old.swap(table_);
    for (const KeyEntry& entry : old)
      if (entry.value >= 0) table_[table().place(entry.key)] = entry;
  }
  std::vector<KeyEntry> table_;
  std::size_t keys_ = 0;
};

}  // namespace turgor::lattice
