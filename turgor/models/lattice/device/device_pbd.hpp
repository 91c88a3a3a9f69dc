// Constraints of PBD in device memory, in the order in which the sweeps project them.
#pragma once

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/device/device_nodes.hpp"
#include "turgor/models/lattice/solver/pbd_kernels.hpp"

namespace turgor::lattice {

template <class Backend>
struct DevicePbd {
  template <class T>
  using Array = typename Backend::template Array<T>;

  Array<NodeKind> kinds;
  Array<std::uint16_t> kind;
  Array<int> constraint_groups, heads, next;
  ColorBegin constraint_groups_of_color, heads_of_color;

  DevicePbd(DeviceAllocator<Backend>& allocator, const PbdOrdering& ordering)
      : kinds(allocator.copy(ordering.kinds)),
        kind(allocator.copy(ordering.kind)),
        constraint_groups(allocator.copy(ordering.constraint_groups)),
        heads(allocator.copy(ordering.heads)),
        next(allocator.copy(ordering.next)),
        constraint_groups_of_color(ordering.constraint_groups_of_color),
        heads_of_color(ordering.heads_of_color) {}

  PbdView view(const Model& model, const DeviceNodes<Backend>& nodes) const {
    return {.rules = pbd_rules(model),
            .body = nodes.view(),
            .kinds = kinds.data(),
            .kind = kind.data(),
            .constraint_groups = constraint_groups.data(),
            .constraint_groups_of_color = constraint_groups_of_color,
            .triangles = nodes.triangles.data(),
            .skin_cut = nodes.skin_cut.data(),
            .next = next.data(),
            .heads = heads.data(),
            .heads_of_color = heads_of_color};
  }
};

}  // namespace turgor::lattice
