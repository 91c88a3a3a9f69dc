// Coarse space in device memory: lists uploaded when the space was rebuilt, and workspaces of a step.
#pragma once

#include "turgor/core/assert.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/coarse/coarse_kernels.hpp"

namespace turgor::lattice {

template <class Backend>
struct DeviceSparse {
  DeviceList<Backend, SparseTerm> terms;
  DeviceList<Backend, int> segment_begin, row_begin;

  void assign(const SparseRows& rows) {
    terms.assign(rows.terms), segment_begin.assign(rows.segment_begin), row_begin.assign(rows.row_begin);
  }
  int segments() const { return int(segment_begin.count) - 1; }
  SparseView view() const {
    return {terms.data(), segment_begin.data(), row_begin.data(), segments(), int(row_begin.count) - 1};
  }
};

template <class Backend>
struct DeviceCoarse {
  template <class T>
  using List = DeviceList<Backend, T>;

  std::shared_ptr<const CoarseSpace> space;  // owner of the uploaded lists
  List<CoarseBlock> blocks;
  List<int> fine_nodes, slot_of_virtual_node;
  List<Chunk> chunks;
  DeviceSparse<Backend> to_unknowns, lower, upper, to_corners;
  List<Vec3> forces, virtual_node_forces;
  List<double> corner_sums, segment_sums, restricted_residual, intermediate, correction, slopes;
  List<float> corners;
  List<SecantSearch> search;

  /// Allocates the per-node arrays.
  DeviceCoarse(DeviceAllocator<Backend>& allocator, const Model& m) {
    forces.array = allocator.template allocate<Vec3>(m.anatomy.inverse_mass.size());
    fine_nodes.array = allocator.template allocate<int>(std::size_t(m.anatomy.free_nodes));
  }

  void upload(const Model& model, const CutElements& elements, std::size_t virtual_nodes,
              const std::shared_ptr<const CoarseSpace>& now) {
    TURGOR_ASSERT(now != nullptr, "a coarse correction needs a coarse space");
    if (space == now) return;
    space = now;
    // lists
    const CoarseLists lists = coarse_lists(model, elements, virtual_nodes, *space);
    blocks.assign(lists.blocks), fine_nodes.assign(lists.fine_nodes),
        slot_of_virtual_node.assign(lists.slot_of_virtual_node);
    chunks.assign(lists.chunks);
    to_unknowns.assign(lists.to_unknowns), lower.assign(lists.lower), upper.assign(lists.upper);
    to_corners.assign(lists.to_corners);
    // workspaces
    forces.resize(model.anatomy.inverse_mass.size()), virtual_node_forces.resize(virtual_nodes);
    corner_sums.resize(24 * chunks.count);
    const int most =
        std::max({to_unknowns.segments(), lower.segments(), upper.segments(), to_corners.segments()});
    segment_sums.resize(3 * std::size_t(most));
    const auto unknowns = 3 * std::size_t(space->unknowns);
    restricted_residual.resize(unknowns), intermediate.resize(unknowns), correction.resize(unknowns),
        slopes.resize(unknowns);
    corners.resize(3 * (space->row_begin.size() - 1));
    search.resize(1);
  }
  CoarseView view(const Model& model) const {
    return {.lattice = model.anatomy.lattice,
            .blocks = blocks.data(),
            .fine_nodes = fine_nodes.data(),
            .slot_of_virtual_node = slot_of_virtual_node.data(),
            .chunks = chunks.data(),
            .chunk_count = int(chunks.count),
            .to_unknowns = to_unknowns.view(),
            .lower = lower.view(),
            .upper = upper.view(),
            .to_corners = to_corners.view(),
            .forces = forces.data(),
            .virtual_node_forces = virtual_node_forces.data(),
            .corner_sums = corner_sums.data(),
            .segment_sums = segment_sums.data(),
            .restricted_residual = restricted_residual.data(),
            .intermediate = intermediate.data(),
            .correction = correction.data(),
            .slopes = slopes.data(),
            .corners = corners.data(),
            .search = search.data()};
  }
};

}  // namespace turgor::lattice
