// Where air beside the body goes: with the tissue beside it. Pure functions, for the CPU and for threads of a
// GPU.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct MeanVec {
  Vec3 sum;
  int count = 0;

  TURGOR_HD void add(Vec3 v) { sum += v, count++; }
  TURGOR_HD Vec3 mean() const { return sum / Real(count); }
};

/// Step n of 27 to what is around a node; 13 is none.
TURGOR_HD inline Int3 way_around(int n) { return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}; }
/// Does an edge lead that way, up or down?
TURGOR_HD inline bool is_edge_way(Int3 way) {
  return (way.x >= 0 && way.y >= 0 && way.z >= 0) || (way.x <= 0 && way.y <= 0 && way.z <= 0);
}

/// Of the tissue within two steps.
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

/// Where the line from one node through the next leads after as long a way again. Tissue that is pressed
/// shorter between them is not drawn shorter beyond: there it bears nothing, and tools find it as thick as it
/// was.
TURGOR_HD inline Vec3 extrapolate(Vec3 behind, Vec3 here, Vec3 way) {
  const Vec3 now = way + (here - behind);
  const Real length = norm(way), length_now = norm(now);
  return length_now < length && length_now > 0 ? here + now * (length / length_now) - way : here + now - way;
}

/// What the tissue beside an air node suggests for its displacement, on average: it goes on along the line
/// through a neighbour from the node behind that, where there is one and no blade went between them; if not
/// along an axis, along another edge or across a cell; else it is that of the neighbours, or of the tissue
/// within two steps. `body` has is_solid(slot), u(slot) and is_parted(beside, behind, way), of neighbours of
/// which the first is the way from the node.
template <class Body>
TURGOR_HD Vec3 extrapolate_from_neighbors(const Lattice& l, const Body& body, int slot) {
  const int parity = slot_node(l, slot).x & 1;
  MeanVec along_axis, along_edge, across_cell, beside_edge, beside_cell;
  for (int n = 0; n < 27; n++) {
    const Int3 way = way_around(n);
    const int beside = slot + slot_offset(l, way, parity);
    if (n == 13 || !body.is_solid(beside)) continue;
    const Vec3 here = body.u(beside);
    const bool is_edge = is_edge_way(way);
    (is_edge ? beside_edge : beside_cell).add(here);
    const int behind = beside + slot_offset(l, way, (parity + way.x) & 1);
    if (!body.is_solid(behind) || body.is_parted(beside, behind, way)) continue;
    const bool is_axis = way.x * way.x + way.y * way.y + way.z * way.z == 1;
    (is_axis   ? along_axis
     : is_edge ? along_edge
               : across_cell)
        .add(extrapolate(body.u(behind), here, -hadamard(l.step, Vec3(way))));
  }
  if (along_axis.count > 0) return along_axis.mean();
  if (along_edge.count > 0) return along_edge.mean();
  if (across_cell.count > 0) return across_cell.mean();
  if (beside_edge.count > 0) return beside_edge.mean();
  if (beside_cell.count > 0) return beside_cell.mean();
  return mean_of_box(l, body, slot_node(l, slot));
}

}  // namespace turgor::lattice
