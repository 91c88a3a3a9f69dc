// Where threads put the contacts that they find: every one goes through what it looks at twice, to count them
// and, when the counts are summed up, to put them in their places.
#pragma once

#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {

struct Found {
  int* count;     // of each thread; in the second pass where its first one goes, and the end
  Contact* list;  // null in the first pass

  /// visit(take) calls take(contact) for all of thread n.
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
