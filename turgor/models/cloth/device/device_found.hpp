// Output of contacts by threads. Each thread runs its search twice: to count its contacts, and after a prefix
// sum of the counts, to write them.
#pragma once

#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {

struct ContactOutput {
  int* count;     // per thread: count in the first pass, offset in the second; and the end
  Contact* list;  // null in the first pass

  /// visit(take) must call take(contact) for all contacts of thread n.
  template <class Visit>
  TURGOR_HD void operator()(std::size_t n, const Visit& visit) const {
    int found = 0;
    if (list == nullptr) {
      visit([&](const Contact&) { found++; });
      count[n] = found;
    } else if (count[n] < count[n + 1]) {
      visit([&](const Contact& c) { list[count[n] + found++] = c; });
    }
  }
};

}  // namespace turgor::cloth
