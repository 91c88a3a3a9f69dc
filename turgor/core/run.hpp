// Runs: run(count, kernel) calls kernel(n) for every n in [0, count), in any order. Kernels are named
// functors over plain views, so that the same loop runs on CPU threads, in shuffled order (tests) or on a GPU
// (gpu_run.cuh).
#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/flush_denormals.hpp"

namespace turgor {

/// Runs on the threads of an Exec. Blocks of `together` consecutive indices stay on one thread, in order, for
/// cache locality.
struct CpuRun {
  const Exec& exec;

  template <class Kernel>
  void operator()(std::size_t count, const Kernel& kernel, std::size_t together = 1) const {
    parallel_for(exec, (count + together - 1) / together, [&](std::size_t block) {
      const std::size_t end = std::min(count, (block + 1) * together);
      for (std::size_t n = block * together; n < end; n++) kernel(n);
    });
  }
};

/// Runs on one thread in an order that the seed determines: shows order-dependent results without a GPU.
struct ShuffledRun {
  unsigned seed = 0;

  template <class Kernel>
  void operator()(std::size_t count, const Kernel& kernel, std::size_t = 1) const {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    const FlushDenormals flush;  // as threads and GPUs do
    for (const std::size_t n : order) kernel(n);
  }
};

/// Calls loops(), which only launches kernels of `run` and does not read their results. A GPU may therefore
/// launch all of them as one graph.
template <class Run, class Loops>
void run_together(const Run&, const Loops& loops) {
  loops();
}

}  // namespace turgor
