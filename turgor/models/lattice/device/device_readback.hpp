// Readback of parts of a device state: given nodes, and surface samples inside given balls.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/atomic_max.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/device_gather.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::lattice {

/// Displacement and velocity of a node [m] [m/s].
struct NodeMotion {
  FreeNodes body;

  TURGOR_HD VectorPair operator()(int slot) const { return {body.nodes.u(slot), body.v(slot)}; }
};

/// Finds the samples inside balls, one thread per sample. The order of `found` is undefined.
struct FindSamples {
  static constexpr int kBalls = 8;
  NodeArrays nodes;
  const SurfaceSample* samples;
  Ball balls[kBalls];
  int ball_count;
  int *found, *found_count;

  TURGOR_HD Vec3 operator()(int slot) const { return nodes.u(slot); }
  TURGOR_HD void operator()(std::size_t n) const {
    const Vec3d x = samples[n].rest + mean_at(samples[n], *this);
    bool is_near = false;
    for (int b = 0; b < ball_count; b++) is_near = is_near || contains(balls[b], x);
    if (is_near) found[atomic_next(*found_count)] = int(n);
  }
};

template <class Backend>
class DeviceReadback {
 public:
  template <class Run>
  void download_nodes(const Run& run, const FreeNodes& body, std::span<const int> slots, Motion& motion) {
    TURGOR_CHECK(all_indices(slots, motion.u.x.size()), "downloaded nodes are slots of the lattice");
    gather_(run, slots, NodeMotion{body}, [&motion](std::size_t slot, const VectorPair& node) {
      motion.u.set(slot, node.first), motion.v.set(slot, node.second);
    });
  }
  /// Samples inside the balls, ascending. A change of `version` uploads the samples again.
  template <class Run>
  std::vector<int> find_samples(const Run& run, const NodeArrays& nodes,
                                std::span<const SurfaceSample> samples, std::uint64_t version,
                                std::span<const Ball> balls) {
    if (version != version_) {
      version_ = 0;  // of no samples, in case that memory is short
      samples_.assign(samples), found_.resize(samples.size());
      version_ = version;
    }
    // up to kBalls per launch
    std::vector<int> found;
    for (std::size_t first = 0; first < balls.size(); first += FindSamples::kBalls) {
      const int none = 0;
      count_.assign({&none, 1});
      FindSamples find{.nodes = nodes,
                       .samples = samples_.data(),
                       .ball_count = int(std::min(balls.size() - first, std::size_t(FindSamples::kBalls))),
                       .found = found_.data(),
                       .found_count = count_.data()};
      std::copy_n(balls.begin() + std::ptrdiff_t(first), find.ball_count, find.balls);
      run(samples.size(), find);
      int more = 0;
      count_.array.download({&more, 1});
      TURGOR_CHECK(is_index(more, samples.size() + 1), "at most all samples are near");
      found.resize(found.size() + std::size_t(more));
      found_.array.download(std::span(found).last(std::size_t(more)));
    }
    sort_unique(found);
    return found;
  }

 private:
  DeviceGather<Backend> gather_;
  DeviceList<Backend, int> found_, count_;
  DeviceList<Backend, SurfaceSample> samples_;
  std::uint64_t version_ = 0;
};

}  // namespace turgor::lattice
