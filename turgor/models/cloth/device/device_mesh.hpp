// Constant data of a sheet on the device: rows, triangles, and the triangles around each vertex.
#pragma once

#include <span>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/forces/membrane_tension.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"

namespace turgor::cloth {

/// Pointer to the data, or null if empty.
template <class Array>
auto* data_or_null(const Array& array) {
  return array.size() > 0 ? array.data() : nullptr;
}

template <class Backend>
struct DeviceRows {
  typename Backend::template Array<int> slot_begin, first, gathered;
  typename Backend::template Array<Real> rest, stiffness, bend;

  DeviceRows(DeviceAllocator<Backend>& allocator, const Rows& rows)
      : slot_begin(allocator.copy(rows.slot_begin)),
        first(allocator.copy(rows.first)),
        gathered(allocator.copy(rows.gathered)),
        rest(allocator.copy(rows.rest)),
        stiffness(allocator.copy(rows.stiffness)),
        bend(allocator.copy(rows.bend)) {}
  RowsView view() const {
    return {data_or_null(slot_begin), data_or_null(first),     data_or_null(gathered),
            data_or_null(rest),       data_or_null(stiffness), data_or_null(bend)};
  }
};

/// Triangles around each vertex, and their membrane data.
template <class Backend>
struct DeviceTriangles {
  template <class T>
  using Array = typename Backend::template Array<T>;

  Array<Int3> corners;
  Array<int> begin, item;  // by vertex, ascending
  MembraneLaw law;
  Array<Real> second[2], third[2];
  Array<std::array<std::uint8_t, 6>> slot;
  Array<std::array<std::uint16_t, 6>> wide_slot;

  DeviceTriangles(DeviceAllocator<Backend>& allocator, const Model& m)
      : DeviceTriangles(allocator, m, lists_around(m.triangles, m.mass.size())) {}
  DeviceTriangles(DeviceAllocator<Backend>& allocator, const Model& m, const NeighborLists& lists)
      : corners(allocator.copy(m.triangles)),
        begin(allocator.copy(lists.begin)),
        item(allocator.copy(lists.item)),
        law(m.membrane.law),
        second{allocator.copy(m.membrane.second[0]), allocator.copy(m.membrane.second[1])},
        third{allocator.copy(m.membrane.third[0]), allocator.copy(m.membrane.third[1])},
        slot(allocator.copy(m.membrane.slot)),
        wide_slot(allocator.copy(m.membrane.wide_slot)) {}

  static NeighborLists lists_around(std::span<const Int3> triangles, std::size_t size) {
    NeighborLists lists;
    lists.begin.assign(size + 2, 0);  // shifted by one while it is filled
    for (const Int3 t : triangles)
      for (int k = 0; k < 3; k++) lists.begin[std::size_t(t[k]) + 2]++;
    for (std::size_t v = 2; v < lists.begin.size(); v++) lists.begin[v] += lists.begin[v - 1];
    lists.item.resize(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); t++)
      for (int k = 0; k < 3; k++)
        lists.item[std::size_t(lists.begin[std::size_t(triangles[t][k]) + 1]++)] = int(t);
    lists.begin.pop_back();
    return lists;
  }
  TrianglesAround around() const { return {begin.data(), item.data()}; }
  MembraneView view() const {
    return {law,
            corners.data(),
            {second[0].data(), second[1].data()},
            {third[0].data(), third[1].data()},
            slot.data(),
            data_or_null(wide_slot)};
  }
};

}  // namespace turgor::cloth
