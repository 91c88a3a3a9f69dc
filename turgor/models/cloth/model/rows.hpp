// The springs around every vertex, sixteen vertices at a time. A batch has as many slots as its vertices
// need; slot s gives each of the sixteen one neighbour. Where these follow one another in memory, as they do
// in a sheet that is numbered row by row, a slot is a plain load instead of a gather.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

/// Between two vertices of the model.
struct Spring {
  int a = 0, b = 0;
  Real rest = 0;       // [m]
  Real stiffness = 0;  // [N/m]
  Real bend = 0;       // force over the way to the other, whatever its length: of bending [N/m]
};

struct Rows {
  std::vector<int> slot_begin;   // of each batch, and the end
  std::vector<int> first;        // of each slot: the neighbour of its first vertex when they follow one
                                 // another, else -1 - 16·(row of `gathered`)
  aligned_vector<int> gathered;  // 16 a slot that is not contiguous
  /// 16 a slot, or none where nothing needs them; stiffness 0 = no neighbour [m] [N/m] [N/m].
  aligned_vector<Real> rest, stiffness, bend;
};

/// Both ends of every spring, for `count` vertices.
Rows make_rows(const std::vector<Spring>& springs, int count);

inline std::size_t batch_count(const Rows& rows) { return rows.slot_begin.size() - 1; }

/// The number of a neighbour.
inline int neighbor(const Rows& rows, int slot, int lane) {
  const int first = rows.first[std::size_t(slot)];
  return first >= 0 ? first + lane : rows.gathered[std::size_t(-1 - first + lane)];
}

/// What the neighbours in a slot have.
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
