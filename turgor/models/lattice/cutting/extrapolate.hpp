// Extrapolation of the displacement field from tissue into adjacent air. Pure functions for host and device.
#pragma once

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct MeanVec {
  Vec3 sum;
  int count = 0;

  TURGOR_HD void add(Vec3 v) { sum += v, count++; }
  TURGOR_HD Vec3 mean() const { return sum / Real(count); }
};

/// Offset n of the 27 offsets in the box around a node; 13 is the node itself.
TURGOR_HD inline Int3 box_offset(int n) { return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}; }
/// True if the offset is an edge of the lattice, in either direction.
TURGOR_HD inline bool is_edge_offset(Int3 offset) {
  return (offset.x >= 0 && offset.y >= 0 && offset.z >= 0) ||
         (offset.x <= 0 && offset.y <= 0 && offset.z <= 0);
}

/// Mean displacement of the tissue within two cells of a node; zero without tissue.
template <class Body>
TURGOR_HD Vec3 mean_of_box(const Lattice& l, const Body& body, Int3 node) {
  MeanVec mean;
  for (int n = 0; n < 125; n++) {
    const Int3 other = node + Int3{n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2};
    if (!contains(l, other)) continue;
    const int slot = node_slot(l, other);
    if (body.is_solid(slot)) mean.add(body.u(slot));
  }
  return mean.count > 0 ? mean.mean() : Vec3{};
}

/// Linear extrapolation of displacement, 2 near_u − far_u, by one more `offset` beyond the nearer of two
/// nodes. If their distance is shorter than at rest, the extrapolated distance is the rest length instead.
/// Tissue beyond the outermost node bears no load, so compression must not continue into it. Tools then find
/// it at its rest thickness.
TURGOR_HD inline Vec3 extrapolate(Vec3 far_u, Vec3 near_u, Vec3 offset) {
  const Vec3 now = offset + (near_u - far_u);
  const Real length = norm(offset), length_now = norm(now);
  return length_now < length && length_now > 0 ? near_u + now * (length / length_now) - offset
                                               : near_u + now - offset;
}

/// Extrapolated displacement of an air node: mean over the first nonempty of these groups of tissue nodes.
///
///   1. extrapolation from two nodes in line along an axis, with no blade between them
///   2. the same along another lattice edge
///   3. the same across a cell
///   4. displacements of neighbors along lattice edges, then across cells
///   5. displacements of all tissue within two cells
///
/// `body` has is_solid(slot), u(slot) and is_separated(near, far, offset), with `offset` pointing from the
/// air node to `near`.
template <class Body>
TURGOR_HD Vec3 extrapolate_from_neighbors(const Lattice& l, const Body& body, int slot) {
  const int parity = slot_node(l, slot).x & 1;
  MeanVec along_axis, along_edge, across_cell, near_edge, near_cell;
  // tissue neighbors, and the tissue behind them in the same direction
  for (int n = 0; n < 27; n++) {
    const Int3 offset = box_offset(n);
    const int near = slot + slot_offset(l, offset, parity);
    if (n == 13 || !body.is_solid(near)) continue;
    const Vec3 near_u = body.u(near);
    const bool is_edge = is_edge_offset(offset);
    (is_edge ? near_edge : near_cell).add(near_u);
    const int far = near + slot_offset(l, offset, (parity + offset.x) & 1);
    if (!body.is_solid(far) || body.is_separated(near, far, offset)) continue;
    const bool is_axis = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z == 1;
    (is_axis   ? along_axis
     : is_edge ? along_edge
               : across_cell)
        .add(extrapolate(body.u(far), near_u, -hadamard(l.spacing, Vec3(offset))));
  }
  // first nonempty group
  if (along_axis.count > 0) return along_axis.mean();
  if (along_edge.count > 0) return along_edge.mean();
  if (across_cell.count > 0) return across_cell.mean();
  if (near_edge.count > 0) return near_edge.mean();
  if (near_cell.count > 0) return near_cell.mean();
  return mean_of_box(l, body, slot_node(l, slot));
}

}  // namespace turgor::lattice
