#include "turgor/core/exec.hpp"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "turgor/core/flush_denormals.hpp"
#include "turgor/core/start_thread.hpp"

namespace turgor {

// Lets arenas have more threads than the machine has cores, which tests of determinism need. There is one
// limit per process because the smallest of several would apply.
namespace {
void allow_many_threads() {
  static const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                         std::max(64u, std::thread::hardware_concurrency()));
}
}  // namespace

struct Exec::Arena {
  explicit Arena(int threads) : arena(threads) {}
  tbb::task_arena arena;
};

// A system that refuses some of the threads gives fewer; oneTBB would end the process.
Exec::Exec(int threads)
    : threads_(startable_threads(
          threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency())))) {
  if (threads_ == 1) return;
  allow_many_threads();
  arena_ = std::make_shared<Arena>(threads_);
}

namespace {

using Body = std::function<void(std::size_t, std::size_t)>;

#ifdef __SANITIZE_THREAD__
// Distributions ship oneTBB without instrumentation. The thread sanitizer would report its hand-over of work
// as races and miss real ones. Plain threads that share the ranges show exactly the races of this program.
template <class Arena>
void spread(Arena&, int threads, std::size_t count, std::size_t grain, const Body& run) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t begin = next.fetch_add(grain); begin < count; begin = next.fetch_add(grain))
      run(begin, std::min(begin + grain, count));
  };
  std::vector<std::thread> others;
  for (int n = 1; n < threads; n++)
    if (Result<std::thread> other = start_thread("a loop", work)) others.push_back(std::move(*other));
  work();
  for (std::thread& other : others) other.join();
}
#else
template <class Arena>
void spread(Arena& arena, int, std::size_t count, std::size_t grain, const Body& run) {
  arena.execute([&] {
    using Range = tbb::blocked_range<std::size_t>;
    tbb::parallel_for(Range(0, count, grain), [&](const Range& range) { run(range.begin(), range.end()); });
  });
}
#endif

}  // namespace

void Exec::run_ranges(std::size_t count, std::size_t grain, const Body& body) const {
  if (count == 0) return;
  const auto run = [&body](std::size_t begin, std::size_t end) {
    const FlushDenormals flush;
    body(begin, end);
  };
  if (threads_ == 1 || count <= grain) return run(0, count);
  spread(arena_->arena, threads_, count, grain, run);
}

}  // namespace turgor
