#include "turgor/core/exec.hpp"

#include <algorithm>
#include <thread>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "turgor/core/flush_denormals.hpp"

namespace turgor {

// Lets arenas have more threads than the machine has cores, as tests of determinism do. One for the process:
// of several, the smallest would count.
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

Exec::Exec(int threads)
    : threads_(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {
  if (threads_ == 1) return;
  allow_many_threads();
  arena_ = std::make_shared<Arena>(threads_);
}

void Exec::run_ranges(std::size_t count, std::size_t grain,
                      const std::function<void(std::size_t, std::size_t)>& body) const {
  if (count == 0) return;
  const auto run = [&body](std::size_t begin, std::size_t end) {
    const FlushDenormals flush;
    body(begin, end);
  };
  if (threads_ == 1 || count <= grain) return run(0, count);
  arena_->arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                      [&](const tbb::blocked_range<std::size_t>& range) { run(range.begin(), range.end()); });
  });
}

}  // namespace turgor
