// What loops are written against that leave the CPU one day: run(count, kernel) calls kernel(n) for every n
// in [0, count), in any order. Kernels are named functors over plain views. A GPU is one more of these.
#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/flush_denormals.hpp"

namespace turgor {

/// The threads of an Exec. So many indices in a row stay `together` on one thread, in order, for the sake of
/// the cache.
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

/// One thread and an order of the seed's own: what depends on the order shows without a GPU.
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

/// Calls loops(), which runs loops of `run` and touches nothing that they do: all of what they are for may be
/// told to a GPU at once.
template <class Run, class Loops>
void run_together(const Run&, const Loops& loops) {
  loops();
}

}  // namespace turgor
