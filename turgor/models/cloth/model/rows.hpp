// Sparse rows of the springs, for sixteen vertices at a time. A batch of vertices has as many slots as
// needed; a slot holds one neighbor of each of the sixteen. If these neighbors are consecutive, as in a grid
// numbered row by row, a slot is a plain load instead of a gather.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

/// Spring between two vertices of the model.
struct Spring {
  int a = 0, b = 0;
  Real rest = 0;       // [m]
  Real stiffness = 0;  // [N/m]
  Real bend = 0;       // bending weight: force per difference of positions [N/m]
};

/// Neighbors and coefficients of all vertices, by batch and slot.
struct Rows {
  std::vector<int> slot_begin;  // first slot of each batch, and the end
  std::vector<int> first;  // of each slot: the neighbor of the first vertex if neighbors are consecutive,
                           // else -1 - 16·(row of `gathered`)
  aligned_vector<int> gathered;  // 16 neighbors of each slot that is not consecutive
  /// 16 coefficients per slot; empty if unused. Stiffness 0: no neighbor [m] [N/m] [N/m].
  aligned_vector<Real> rest, stiffness, bend;
};

/// Rows of `count` vertices from springs; each spring appears in both rows.
Rows make_rows(const std::vector<Spring>& springs, int count);

inline std::size_t batch_count(const Rows& rows) { return rows.slot_begin.size() - 1; }

/// Neighbor of a lane in a slot.
inline int neighbor(const Rows& rows, int slot, int lane) {
  const int first = rows.first[std::size_t(slot)];
  return first >= 0 ? first + lane : rows.gathered[std::size_t(-1 - first + lane)];
}

/// Values of the neighbors in a slot.
inline Lanes3 load_neighbors(const Rows& rows, const Vectors& a, int slot) {
  const int first = rows.first[std::size_t(slot)];
  if (first >= 0) return load(a, std::size_t(first));
  return gather(a, rows.gathered.data() - 1 - first);
}

inline Lanes load_neighbors(const Rows& rows, const aligned_vector<Real>& a, int slot) {
  const int first = rows.first[std::size_t(slot)];
  if (first >= 0) return load_lanes(&a[std::size_t(first)]);
  return gather_lanes(a.data(), rows.gathered.data() - 1 - first);
}

}  // namespace turgor::cloth
