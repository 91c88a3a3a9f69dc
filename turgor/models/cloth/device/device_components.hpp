// Components of a sheet on the device. Those without held vertices start a step with the velocity change of
// their total force (component_kernels.hpp).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/solver/component_kernels.hpp"

namespace turgor::cloth {

/// Components of a sheet, and the masses of those without held vertices.
template <class Backend>
class DeviceComponents {
 public:
  DeviceComponents(DeviceAllocator<Backend>& allocator, const Model& m)
      : DeviceComponents(allocator, m, components_of(m), chunks_of(m)) {}

  /// Sets which components have held vertices.
  void set_held(const Model& m, std::span<const Hold> holds) {
    any_free_ = false;
    for (std::size_t p = 0; p < infos_.size(); p++) {
      const auto at = std::lower_bound(holds.begin(), holds.end(), m.component_begin[p],
                                       [](const Hold& h, int v) { return h.vertex < v; });
      const bool is_held = at != holds.end() && at->vertex < m.component_begin[p + 1];
      infos_[p].mass = is_held ? 0 : masses_[p];
      any_free_ = any_free_ || !is_held;
    }
    components_.upload(infos_);
  }
  /// Sums the wind's diagonal of each component.
  template <class Run>
  void sum_drag(const Run& run, const SheetView& sheet) {
    if (any_free_) run(chunks_.size(), SumDrag{chunks_.data(), sheet.inverse[0], sums_.data()});
  }
  /// Initial guess of the sweeps.
  template <class Run>
  void start(const Run& run, const SheetView& sheet, double mass_factor, bool has_air) {
    if (any_free_) {
      run(chunks_.size(), SumForce{chunks_.data(), sheet.force, sums_.data()});
      run(components_.size(),
          FindComponentVelocity{components_.data(), sums_.data(), mass_factor, has_air, velocity_.data()});
    }
    run(sheet.size, StartChange{sheet, component_of_.data(), any_free_ ? velocity_.data() : nullptr});
  }

 private:
  static constexpr int kChunkSize = 512;

  DeviceComponents(DeviceAllocator<Backend>& allocator, const Model& m, std::vector<int> component_of,
                   std::vector<ComponentChunk> chunks)
      : component_of_(allocator.copy(component_of)),
        chunks_(allocator.copy(chunks)),
        sums_(allocator.template allocate<ComponentSum>(chunks.size())),
        velocity_(allocator.template allocate<Vec3>(m.component_begin.size() - 1)),
        components_(allocator.template allocate<ComponentInfo>(m.component_begin.size() - 1)) {
    int chunk = 0;
    for (std::size_t p = 0; p + 1 < m.component_begin.size(); p++) {
      const int begin = m.component_begin[p], end = m.component_begin[p + 1];
      const int count = (end - begin + kChunkSize - 1) / kChunkSize;
      infos_.push_back({chunk, chunk + count, 0});
      chunk += count;
      double mass = 0;
      for (int v = begin; v < end; v++) mass += double(m.mass[std::size_t(v)]);
      masses_.push_back(mass);
    }
  }
  static std::vector<int> components_of(const Model& m) {
    std::vector<int> of(m.mass.size(), -1);
    for (std::size_t p = 0; p + 1 < m.component_begin.size(); p++)
      std::fill(of.begin() + m.component_begin[p], of.begin() + m.component_begin[p + 1], int(p));
    return of;
  }
  static std::vector<ComponentChunk> chunks_of(const Model& m) {
    std::vector<ComponentChunk> chunks;
    for (std::size_t p = 0; p + 1 < m.component_begin.size(); p++)
      for (int v = m.component_begin[p]; v < m.component_begin[p + 1]; v += kChunkSize)
        chunks.push_back({v, std::min(v + kChunkSize, m.component_begin[p + 1])});
    return chunks;
  }

  typename Backend::template Array<int> component_of_;
  typename Backend::template Array<ComponentChunk> chunks_;
  typename Backend::template Array<ComponentSum> sums_;
  typename Backend::template Array<Vec3> velocity_;
  typename Backend::template Array<ComponentInfo> components_;
  std::vector<ComponentInfo> infos_;
  std::vector<double> masses_;  // [kg]
  bool any_free_ = true;
};

}  // namespace turgor::cloth
