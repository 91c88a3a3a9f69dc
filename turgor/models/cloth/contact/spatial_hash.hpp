// Spatial hash: points sorted into hashed cells. The paper's two shifted grids miss pairs, so a cell is
// at least twice the reach, and the eight cells around a point contain all points within reach. Cells
// adjacent along x have adjacent buckets: eight cells are four runs of memory, tested sixteen points at a
// time.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

/// Sorts the first `count` points. `cell` must exceed twice the largest reach of a query.
void sort_points(const Exec& exec, const Vectors& points, int count, Real cell, SpatialHash& near);

TURGOR_HD inline int cell_of(Real x, Real inverse_cell) {
  constexpr Real kFar = 1e9f;  // fits an int; points beyond share the last cell
  return int(std::floor(smaller(larger(x * inverse_cell, -kFar), kFar)));
}
/// Bucket of the cell (0, cy, cz); cell cx is cx buckets further.
TURGOR_HD inline std::uint32_t row_bucket(int cy, int cz) {
  const std::uint32_t h = std::uint32_t(cy) * 0x9e3779b1u ^ std::uint32_t(cz) * 0x85ebca77u;
  return (h ^ h >> 15) * 0x2c1b3c6du;
}

/// Calls visit(point, position) for the sorted points [from, to) that pass. `passes` gets sixteen positions
/// and the index of the first, and returns a bit for each.
template <class Passes, class Visit>
void visit_run(const SpatialHash& near, int from, int to, const Passes& passes, const Visit& visit) {
  for (int n = from; n < to; n += kLanes) {
    const auto s = std::size_t(n);
    unsigned hits = passes(Lanes3{load_lanes(&near.x[s]), load_lanes(&near.y[s]), load_lanes(&near.z[s])}, s);
    if (to - n < kLanes) hits &= (1u << (to - n)) - 1;
    for (; hits != 0; hits &= hits - 1) {
      const std::size_t hit = s + std::size_t(std::countr_zero(hits));
      visit(near.index[hit], Vec3{near.x[hit], near.y[hit], near.z[hit]});
    }
  }
}

/// Cells that overlap a box.
struct CellBox {
  Int3 low, high;

  TURGOR_HD CellBox(Real inverse_cell, Vec3 a, Vec3 b)
      : low(cell_of(a.x, inverse_cell), cell_of(a.y, inverse_cell), cell_of(a.z, inverse_cell)),
        high(cell_of(b.x, inverse_cell), cell_of(b.y, inverse_cell), cell_of(b.z, inverse_cell)) {}
  /// True if the cells outnumber the buckets, so that all points are tested bucket by bucket.
  TURGOR_HD bool is_all(std::uint32_t mask) const {
    const auto count = [](int from, int to) { return double(to) - from + 1; };
    return count(low.x, high.x) * count(low.y, high.y) * count(low.z, high.z) > double(mask);
  }
};

/// Calls visit(from, to, is_own) for runs of sorted points that contain all points of a box. is_own(position)
/// rejects points of other cells in the same buckets.
template <class Visit>
TURGOR_HD inline void visit_runs(Real cell, std::uint32_t mask, const int* begin, int count, Vec3 low,
                                 Vec3 high, const Visit& visit) {
  // cells of the box
  const Real inverse = 1 / cell;
  const CellBox cells(inverse, low, high);
  if (cells.is_all(mask)) return visit(0, count, [](Vec3) { return true; });
  const int x0 = cells.low.x, x1 = cells.high.x;
  for (int cz = cells.low.z; cz <= cells.high.z; cz++)
    for (int cy = cells.low.y; cy <= cells.high.y; cy++) {
      const auto is_own = [&](Vec3 p) {  // other rows may share buckets
        return cell_of(p.y, inverse) == cy && cell_of(p.z, inverse) == cz;
      };
      // buckets of a row of cells, which may wrap around
      const std::uint32_t first = (row_bucket(cy, cz) + std::uint32_t(x0)) & mask,
                          last = first + std::uint32_t(x1 - x0);
      visit(begin[first], begin[(last < mask ? last : mask) + 1], is_own);
      if (last > mask) visit(0, begin[last - mask], is_own);
    }
}

/// Calls visit(point, position) once for every point that passes. `passes` gets sixteen positions and the
/// index of the first, and returns a bit for each. No point outside the box may pass.
template <class Passes, class Visit>
void visit_box(const SpatialHash& near, Vec3 low, Vec3 high, const Passes& passes, const Visit& visit) {
  visit_runs(near.cell, near.mask, near.begin.data(), int(near.index.size()), low, high,
             [&](int from, int to, const auto& is_own) {
               visit_run(near, from, to, passes, [&](int point, Vec3 p) {
                 if (is_own(p)) visit(point, p);
               });
             });
}

/// Calls visit(point, position) once for every point within `reach` of p; reach must be below half a cell.
template <class Visit>
void visit_near(const SpatialHash& near, Vec3 p, Real reach, const Visit& visit) {
  const Real half = near.cell / 2, reach2 = reach * reach;
  const auto passes = [&](Lanes3 q, std::size_t) {
    const Lanes3 d{q.x - p.x, q.y - p.y, q.z - p.z};
    return lanes_below(dot(d, d), reach2);
  };
  visit_box(near, p - Vec3{half, half, half}, p + Vec3{half, half, half}, passes, visit);
}

}  // namespace turgor::cloth
