// What somebody looks at of a body on the other side of a bus: some of its nodes, and which places of its
// surface are near. Only they come back.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/atomic_max.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/surface/surface_sample.hpp"

namespace turgor::lattice {

struct NodeNow {
  Vec3 u, v;  // [m], [m/s]
};
/// A thread a node that is looked at.
struct GatherNode {
  MovingNodes body;
  const int* slots;
  NodeNow* now;

  TURGOR_HD void operator()(std::size_t n) const { now[n] = {body.nodes.u(slots[n]), body.v(slots[n])}; }
};

/// A thread a place: writes it down if it is in one of the balls, in no order.
struct FindPlace {
  static constexpr int kBalls = 8;
  NodeArrays nodes;
  const SurfaceSample* places;
  Ball balls[kBalls];
  int ball_count;
  int *found, *found_count;

  TURGOR_HD Vec3 operator()(int slot) const { return nodes.u(slot); }
  TURGOR_HD void operator()(std::size_t n) const {
    const Vec3d x = places[n].rest + mean_at(places[n], *this);
    bool is_near = false;
    for (int b = 0; b < ball_count; b++) is_near = is_near || contains(balls[b], x);
    if (is_near) found[atomic_next(*found_count)] = int(n);
  }
};

template <class Side>
class DeviceReadback {
 public:
  template <class Run>
  void get(const Run& run, const MovingNodes& body, std::span<const int> slots, State& state) {
    slots_.put(slots), now_.fit(slots.size());
    run(slots.size(), GatherNode{body, slots_.data(), now_.data()});
    std::vector<NodeNow> now(slots.size());
    now_.room.download(now);
    for (std::size_t n = 0; n < now.size(); n++) {
      const auto slot = std::size_t(slots[n]);
      state.u.set(slot, now[n].u), state.v.set(slot, now[n].v);
    }
  }
  /// `version`: another one with other places.
  template <class Run>
  std::vector<int> find(const Run& run, const NodeArrays& nodes, std::span<const SurfaceSample> places,
                        std::uint64_t version, std::span<const Ball> balls) {
    if (version != version_) places_.put(places), found_.fit(places.size()), version_ = version;
    std::vector<int> found;
    for (std::size_t first = 0; first < balls.size(); first += FindPlace::kBalls) {
      const int none = 0;
      count_.put({&none, 1});
      FindPlace find{.nodes = nodes,
                     .places = places_.data(),
                     .ball_count = int(std::min(balls.size() - first, std::size_t(FindPlace::kBalls))),
                     .found = found_.data(),
                     .found_count = count_.data()};
      std::copy_n(balls.begin() + std::ptrdiff_t(first), find.ball_count, find.balls);
      run(places.size(), find);
      int more = 0;
      count_.room.download({&more, 1});
      found.resize(found.size() + std::size_t(more));
      found_.room.download(std::span(found).last(std::size_t(more)));
    }
    sort_unique(found);
    return found;
  }

 private:
  DeviceList<Side, int> slots_, found_, count_;
  DeviceList<Side, NodeNow> now_;
  DeviceList<Side, SurfaceSample> places_;
  std::uint64_t version_ = 0;
};

}  // namespace turgor::lattice
