// Runs of active slots. Most of a CT is air, and bone is fixed, so loops visit runs of whole slot groups as
// SIMD.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/lattice.hpp"

namespace turgor::lattice {

/// Slots per group. Half rows are whole numbers of groups.
constexpr int kGroup = 8;

/// Slots [begin, begin + count) of one half row: whole groups, counted from the start of the half row.
struct Run {
  int begin = 0, count = 0;
};

struct Runs {
  std::vector<Run> all;        // in slot order
  std::vector<int> row_begin;  // by half row of the storage, plus the end: indices into `all`

  std::span<const Run> of_half_row(int half_row) const {
    TURGOR_CHECK(is_index(half_row + 1, row_begin.size()), "the half row belongs to the lattice");
    const auto at = std::size_t(half_row);
    return {all.data() + row_begin[at], all.data() + row_begin[at + 1]};
  }
};

inline std::size_t slots_in(const Runs& runs) {
  std::size_t slots = 0;
  for (const Run run : runs.all) slots += std::size_t(run.count);
  return slots;
}

/// Groups that contain a slot for which `wanted` is true, merged to runs. `wanted` is called for slots of
/// nodes only.
template <class Wanted>
Runs find_runs(const Lattice& l, const Wanted& wanted) {
  Runs runs;
  const auto add_group = [&](int begin, bool extends) {
    if (extends)
      runs.all.back().count += kGroup;
    else
      runs.all.push_back({begin, kGroup});
  };
  const auto add_half_row = [&](int first, int nodes) {
    bool extends = false;
    for (int begin = 0; begin < nodes; begin += kGroup) {
      bool any = false;
      for (int i = begin; i < std::min(begin + kGroup, nodes); i++) any |= wanted(first + i);
      if (any) add_group(first + begin, extends);
      extends = any;
    }
  };
  runs.row_begin.assign(std::size_t(slot_count(l) / l.half + 1), 0);
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++) {
        const int first = row_slot(l, j, k) + parity * l.half;
        add_half_row(first, half_count(l, parity));
        runs.row_begin[std::size_t(first / l.half + 1)] = int(runs.all.size());
      }
  for (std::size_t r = 1; r < runs.row_begin.size(); r++)
    runs.row_begin[r] = std::max(runs.row_begin[r], runs.row_begin[r - 1]);
  TURGOR_CHECK(is_csr(runs.row_begin, runs.all.size()), "the half rows cover all runs");
  TURGOR_CHECK(std::all_of(runs.all.begin(), runs.all.end(),
                           [&](Run r) {
                             return r.begin % l.half % kGroup == 0 && r.count % kGroup == 0 && r.count > 0;
                           }),
               "runs cover whole groups");
  return runs;
}

}  // namespace turgor::lattice
