// Arrays of a body in device memory that both solvers need: nodes, cuts and skin triangles.
#pragma once

#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"

namespace turgor::lattice {

template <class Backend>
struct DeviceNodes {
  template <class T>
  using Array = typename Backend::template Array<T>;

  int half;
  DeviceVectors<Backend> u, u_before, v;
  Array<Real> w, root;
  Array<std::uint8_t> cut, removed, skin_cut;
  ColorBegin free_groups_of_color;
  Array<int> free_groups;
  Array<SkinTriangle> triangles;
  Array<StepSummary> summary;

  DeviceNodes(DeviceAllocator<Backend>& allocator, const Model& m)
      : half(m.anatomy.lattice.half),
        u(allocator, m.anatomy.inverse_mass.size()),
        u_before(allocator, m.anatomy.inverse_mass.size()),
        v(allocator, m.anatomy.inverse_mass.size()),
        w(allocator.copy(m.anatomy.inverse_mass)),
        root(allocator.copy(m.springs.root_stiffness)),
        cut(allocator.template allocate<std::uint8_t>(m.anatomy.inverse_mass.size())),
        removed(allocator.template allocate<std::uint8_t>(m.anatomy.inverse_mass.size())),
        skin_cut(allocator.template allocate<std::uint8_t>(skin_element_count(m.anatomy.skin))),
        free_groups(allocator.copy(groups(m, free_groups_of_color))),
        triangles(allocator.copy(m.anatomy.skin.triangles)),
        summary(allocator.template allocate<StepSummary>(1)) {}

  static std::vector<int> groups(const Model& m, ColorBegin& of) {
    std::vector<int> first;
    of = groups_by_colors(m.anatomy.lattice, m.anatomy.free_runs, first);
    return first;
  }
  void upload_cuts(const Cuts& cuts) {
    cut.upload(cuts.cut), removed.upload(cuts.removed), skin_cut.upload(cuts.skin_cut);
  }
  FreeNodes view() const {
    return {.half = half,
            .slots = int(w.size()),
            .nodes = {u.x.data(), u.y.data(), u.z.data(), w.data(), root.data(), cut.data()},
            .bx = u_before.x.data(),
            .by = u_before.y.data(),
            .bz = u_before.z.data(),
            .vx = v.x.data(),
            .vy = v.y.data(),
            .vz = v.z.data(),
            .removed = removed.data(),
            .free_groups = free_groups.data(),
            .free_group_count = int(free_groups.size()),
            .summary = summary.data()};
  }
};

}  // namespace turgor::lattice
