// Readback of parts of a sheet on the device: given vertices, and contacts that load obstacles or held
// vertices.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "turgor/core/atomic_max.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/device_gather.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Position and velocity of a vertex [m] [m/s].
struct VertexMotion {
  ConstVectorsView x, v;

  TURGOR_HD VectorPair operator()(int vertex) const {
    return {x[std::size_t(vertex)], v[std::size_t(vertex)]};
  }
};

/// Finds contacts with an impulse on an obstacle or a held vertex, one thread per contact. The order of
/// `found` is undefined.
struct FindLoads {
  const Contact* list;
  const Hold* holds;  // ascending by vertex
  int hold_count;
  int *found, *found_count;

  TURGOR_HD bool is_held(int vertex) const {
    int begin = 0, end = hold_count;
    while (begin < end) {
      const int middle = (begin + end) / 2;
      if (holds[middle].vertex == vertex) return true;
      holds[middle].vertex < vertex ? begin = middle + 1 : end = middle;
    }
    return false;
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const Contact& c = list[n];
    bool is_wanted = c.obstacle >= 0;
    for (std::size_t k = 0; k < 4 && !is_wanted; k++) is_wanted = c.vertex[k] >= 0 && is_held(c.vertex[k]);
    if (is_wanted && (c.impulse != 0 || !(c.friction_impulse == Vec3{})))
      found[atomic_next(*found_count)] = int(n);
  }
};
/// Load of a contact, without what only its solver reads.
struct LoadNow {
  int contact;
  std::array<int, 4> vertex;
  std::array<Real, 4> weight;
  int obstacle;
  Vec3 normal, friction_impulse;
  Real impulse;
};
/// Gathers contacts, one thread per contact.
struct GatherLoad {
  const Contact* list;
  const int* found;
  LoadNow* now;

  TURGOR_HD void operator()(std::size_t n) const {
    const Contact& c = list[found[n]];
    now[n] = {found[n], c.vertex, c.weight, c.obstacle, c.normal, c.friction_impulse, c.impulse};
  }
};

template <class Backend>
class DeviceReadback {
 public:
  template <class Run>
  void download_vertices(const Run& run, ConstVectorsView x, ConstVectorsView v,
                         std::span<const int> vertices, State& state) {
    TURGOR_CHECK(all_indices(vertices, state.x.size()), "downloaded vertices are of the cloth");
    gather_(run, vertices, VertexMotion{x, v}, [&state](std::size_t i, const VectorPair& motion) {
      state.x.set(i, motion.first), state.v.set(i, motion.second);
    });
  }
  /// Contacts with an impulse on an obstacle or a held vertex, in the order of the list.
  template <class Run>
  std::vector<Contact> download_loads(const Run& run, std::span<const Contact> list,
                                      std::span<const Hold> holds) {
    if (list.empty()) return {};
    // find
    const int none = 0;
    count_.assign({&none, 1}), found_.resize(list.size());
    run(list.size(), FindLoads{list.data(), holds.data(), int(holds.size()), found_.data(), count_.data()});
    int count = 0;
    count_.array.download({&count, 1});
    TURGOR_CHECK(is_index(count, list.size() + 1), "at most all contacts are loads");
    if (count == 0) return {};
    // gather
    loads_now_.resize(std::size_t(count));
    run(std::size_t(count), GatherLoad{list.data(), found_.data(), loads_now_.data()});
    std::vector<LoadNow> now(static_cast<std::size_t>(count));
    loads_now_.array.download(now);
    std::sort(now.begin(), now.end(),
              [](const LoadNow& a, const LoadNow& b) { return a.contact < b.contact; });
    // contacts with these values
    std::vector<Contact> contacts;
    for (const LoadNow& load : now) {
      Contact& contact = contacts.emplace_back();
      contact.vertex = load.vertex, contact.weight = load.weight, contact.obstacle = load.obstacle;
      contact.normal = load.normal;
      contact.impulse = load.impulse, contact.friction_impulse = load.friction_impulse;
    }
    return contacts;
  }

 private:
  DeviceGather<Backend> gather_;
  DeviceList<Backend, int> found_, count_;
  DeviceList<Backend, LoadNow> loads_now_;
};

}  // namespace turgor::cloth
