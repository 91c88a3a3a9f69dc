// Threads for loops. Exec owns a number of threads; parallel_for spreads independent indices over them. Loops
// never depend on the order in which indices run, so results have the same bits for every thread count. Loops
// that also run on a GPU are written against run.hpp.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace turgor {

/// A set of worker threads. Cheap to copy; copies share the threads.
class Exec {
 public:
  /// `threads` = 0 takes one thread per core.
  explicit Exec(int threads = 0);
  int threads() const { return threads_; }

  /// Calls body(begin, end) on disjoint ranges that cover [0, count); ranges hold at least `grain` indices.
  /// Denormal numbers are flushed to zero inside.
  void run_ranges(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const;

 private:
  struct Arena;
  int threads_;
  std::shared_ptr<Arena> arena_;
};

/// Calls kernel(index) for every index in [0, count), in any order and on any thread.
template <class Kernel>
void parallel_for(const Exec& exec, std::size_t count, const Kernel& kernel, std::size_t grain = 1) {
  exec.run_ranges(count, grain, [&kernel](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i++) kernel(i);
  });
}

}  // namespace turgor
