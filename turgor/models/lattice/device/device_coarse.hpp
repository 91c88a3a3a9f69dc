// A coarse space on one side of a bus or the other: its lists, which go over when it was made anew, and room
// for a step in it.
#pragma once

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/coarse/coarse_kernels.hpp"

namespace turgor::lattice {

template <class Side>
struct DeviceSparse {
  DeviceList<Side, SparseTerm> terms;
  DeviceList<Side, int> piece_begin, row_begin;

  void put(const SparseRows& rows) {
    terms.put(rows.terms), piece_begin.put(rows.piece_begin), row_begin.put(rows.row_begin);
  }
  int pieces() const { return int(piece_begin.count) - 1; }
  SparseView view() const {
    return {terms.data(), piece_begin.data(), row_begin.data(), pieces(), int(row_begin.count) - 1};
  }
};

template <class Side>
struct DeviceCoarse {
  template <class T>
  using List = DeviceList<Side, T>;

  std::shared_ptr<const CoarseSpace> space;  // whose lists these are
  List<CoarseBlock> blocks;
  List<int> followers, slot_of_virtual_node;
  List<Stretch> stretches;
  DeviceSparse<Side> to_unknowns, lower, upper, to_corners;
  List<Vec3> forces, virtual_node_forces;
  List<double> corner_sums, piece_sums, wanted, halfway, way, slopes;
  List<float> corners;
  List<CoarseSearch> search;

  /// What there is one of for every node is asked for at once.
  DeviceCoarse(DeviceAllocator<Side>& rooms, const Model& m) {
    forces.room = rooms.template room<Vec3>(m.inverse_mass.size());
    followers.room = rooms.template room<int>(std::size_t(m.free_nodes));
  }

  void put(const Model& model, const State& known) {
    if (space == known.coarse) return;
    space = known.coarse;
    const CoarseLists lists = coarse_lists(model, known, *space);
    blocks.put(lists.blocks), followers.put(lists.followers),
        slot_of_virtual_node.put(lists.slot_of_virtual_node);
    stretches.put(lists.stretches);
    to_unknowns.put(lists.to_unknowns), lower.put(lists.lower), upper.put(lists.upper);
    to_corners.put(lists.to_corners);
    forces.fit(model.inverse_mass.size()), virtual_node_forces.fit(known.virtual_nodes.size());
    corner_sums.fit(24 * stretches.count);
    const int most = std::max({to_unknowns.pieces(), lower.pieces(), upper.pieces(), to_corners.pieces()});
    piece_sums.fit(3 * std::size_t(most));
    const auto numbers = 3 * std::size_t(space->unknowns);
    wanted.fit(numbers), halfway.fit(numbers), way.fit(numbers), slopes.fit(numbers);
    corners.fit(3 * (space->row_begin.size() - 1));
    search.fit(1);
  }
  CoarseView view(const Model& model) const {
    return {.lattice = model.lattice,
            .blocks = blocks.data(),
            .followers = followers.data(),
            .slot_of_virtual_node = slot_of_virtual_node.data(),
            .stretches = stretches.data(),
            .stretch_count = int(stretches.count),
            .to_unknowns = to_unknowns.view(),
            .lower = lower.view(),
            .upper = upper.view(),
            .to_corners = to_corners.view(),
            .forces = forces.data(),
            .virtual_node_forces = virtual_node_forces.data(),
            .corner_sums = corner_sums.data(),
            .piece_sums = piece_sums.data(),
            .wanted = wanted.data(),
            .halfway = halfway.data(),
            .way = way.data(),
            .slopes = slopes.data(),
            .corners = corners.data(),
            .search = search.data()};
  }
};

}  // namespace turgor::lattice
