// Numbers for keys: 0, 1, 2, … in the order of their first appearance. Open addressing; keys are below 2⁶⁴
// − 1.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace turgor::lattice {

class KeyIndex {
 public:
  int find_or_add(std::uint64_t key) {
    if (2 * (keys_ + 1) > table_.size()) grow();
    Entry& entry = table_[place(key)];
    if (entry.value < 0) entry = {key, int(keys_++)};
    return entry.value;
  }
  /// -1 = unknown.
  int find(std::uint64_t key) const { return table_.empty() ? -1 : table_[place(key)].value; }
  std::size_t size() const { return keys_; }

 private:
  struct Entry {
    std::uint64_t key = 0;
    int value = -1;
  };
  std::size_t place(std::uint64_t key) const {
    std::size_t at = (key * 0x9e3779b97f4a7c15ull) >> 20 & (table_.size() - 1);
    while (table_[at].value >= 0 && table_[at].key != key) at = (at + 1) & (table_.size() - 1);
    return at;
  }
  void grow() {
    std::vector<Entry> old(std::max<std::size_t>(1024, 2 * table_.size()));
    old.swap(table_);
    for (const Entry& entry : old)
      if (entry.value >= 0) table_[place(entry.key)] = entry;
  }
  std::vector<Entry> table_;
  std::size_t keys_ = 0;
};

}  // namespace turgor::lattice
