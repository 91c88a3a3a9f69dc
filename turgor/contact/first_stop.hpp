// First position on the path of a crack that tissue does not let through. `is_free(share)` tells whether the
// position at a share of the path is free.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace turgor::contact {

/// Shares of a path: the last one known as free, and the first one that is not.
struct PathStop {
  double free = 0, stopped = 0;
};

/// Stop between two neighbors of samples at most `step` apart; empty if all are free. `length`: of the path
/// [m].
template <class IsFree>
std::optional<PathStop> first_stop(double length, double step, const IsFree& is_free) {
  const int samples = std::max(1, int(std::ceil(length / step)));
  for (int i = 1; i <= samples; i++)
    if (!is_free(double(i) / samples)) return PathStop{double(i - 1) / samples, double(i) / samples};
  return {};
}

/// The same stop after `halvings` bisections. The last call of `is_free` is at its first share that is not
/// free.
template <class IsFree>
PathStop refined(PathStop stop, int halvings, const IsFree& is_free) {
  for (int k = 0; k < halvings; k++) {
    const double middle = (stop.free + stop.stopped) / 2;
    (is_free(middle) ? stop.free : stop.stopped) = middle;
  }
  (void)is_free(stop.stopped);
  return stop;
}

}  // namespace turgor::contact
