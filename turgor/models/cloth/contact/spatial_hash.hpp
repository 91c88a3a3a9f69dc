// Points sorted into cells by hashing, so that all points near a place are found, and no pair is missed. The
// paper's two grids, shifted by half a cell, miss pairs; here a cell is at least twice as large as the reach,
// and the eight cells around a point hold everything within its reach. Cells that follow one another along x
// have buckets that do so too: eight cells are four runs of memory, looked at sixteen points at a time.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct SpatialHash {
  Real cell = 0;  // its side [m]
  std::uint32_t mask = 0;
  std::vector<int> begin;        // of each bucket, and the end
  std::vector<int> bucket;       // of each point
  std::vector<int> index;        // points by bucket
  aligned_vector<Real> x, y, z;  // places by bucket, and a batch to spare [m]
};

/// Sorts the first `count` points. `cell` is more than twice the largest reach that is asked for.
void sort_points(const Exec& exec, const Vectors& points, int count, Real cell, SpatialHash& near);

TURGOR_HD inline int cell_of(Real x, Real inverse_cell) {
  constexpr Real kFar = 1e9f;  // an int holds it; points beyond share the last cell
  return int(std::floor(smaller(larger(x * inverse_cell, -kFar), kFar)));
}
/// Of the cell (0, cy, cz); cell cx is cx further on.
TURGOR_HD inline std::uint32_t row_bucket(int cy, int cz) {
  const std::uint32_t h = std::uint32_t(cy) * 0x9e3779b1u ^ std::uint32_t(cz) * 0x85ebca77u;
  return (h ^ h >> 15) * 0x2c1b3c6du;
}

/// Calls visit(point, place) for the sorted points [from, to) that pass, sixteen at a time; `passes` is given
/// which is the first of them.
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

/// The cells that a box has a part in.
struct CellBox {
  Int3 low, high;

  TURGOR_HD CellBox(Real inverse_cell, Vec3 a, Vec3 b)
      : low(cell_of(a.x, inverse_cell), cell_of(a.y, inverse_cell), cell_of(a.z, inverse_cell)),
        high(cell_of(b.x, inverse_cell), cell_of(b.y, inverse_cell), cell_of(b.z, inverse_cell)) {}
  /// Are they so many that all points are looked at, bucket by bucket?
  TURGOR_HD bool is_all(std::uint32_t mask) const {
    const auto count = [](int from, int to) { return double(to) - from + 1; };
    return count(low.x, high.x) * count(low.y, high.y) * count(low.z, high.z) > double(mask);
  }
};

/// Calls visit(from, to, is_own) for runs of sorted points in which all of a box are; is_own(place) says
/// which of them belong there: buckets have points of other cells, too.
template <class Visit>
TURGOR_HD inline void visit_runs(Real cell, std::uint32_t mask, const int* begin, int count, Vec3 low,
                                 Vec3 high, const Visit& visit) {
  const Real inverse = 1 / cell;
  const CellBox cells(inverse, low, high);
  if (cells.is_all(mask)) return visit(0, count, [](Vec3) { return true; });
  const int x0 = cells.low.x, x1 = cells.high.x;
  for (int cz = cells.low.z; cz <= cells.high.z; cz++)
    for (int cy = cells.low.y; cy <= cells.high.y; cy++) {
      const auto is_own = [&](Vec3 p) {  // other rows have some of the same buckets
        return cell_of(p.y, inverse) == cy && cell_of(p.z, inverse) == cz;
      };
      const std::uint32_t first = (row_bucket(cy, cz) + std::uint32_t(x0)) & mask,
                          last = first + std::uint32_t(x1 - x0);
      visit(begin[first], begin[(last < mask ? last : mask) + 1], is_own);
      if (last > mask) visit(0, begin[last - mask], is_own);
    }
}

/// Calls visit(point, place) once for every point that passes. `passes` takes sixteen places, and where they
/// are among the sorted ones, and returns a bit for each; no point outside of the box may pass.
template <class Passes, class Visit>
void visit_box(const SpatialHash& near, Vec3 low, Vec3 high, const Passes& passes, const Visit& visit) {
  visit_runs(near.cell, near.mask, near.begin.data(), int(near.index.size()), low, high,
             [&](int from, int to, const auto& is_own) {
               visit_run(near, from, to, passes, [&](int point, Vec3 p) {
                 if (is_own(p)) visit(point, p);
               });
             });
}

/// Calls visit(point, place) once for every point within `reach` of p, which is less than half a cell.
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
