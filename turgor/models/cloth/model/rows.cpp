#include "turgor/models/cloth/model/rows.hpp"

#include <algorithm>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

namespace {

struct Half {
  int neighbor = -1;
  Real rest = 0, stiffness = 0, bend = 0;
};
using Batch = std::vector<std::vector<Half>>;  // entries of each lane

void add_slot(Rows& rows, const Half (&lanes)[kLanes], int first, int vertex) {
  if (first < 0) first = -1 - int(rows.gathered.size());
  rows.first.push_back(first);
  for (int l = 0; l < kLanes; l++) {
    rows.rest.push_back(lanes[l].rest);
    rows.stiffness.push_back(lanes[l].stiffness);
    rows.bend.push_back(lanes[l].bend);
    if (first < 0) rows.gathered.push_back(lanes[l].neighbor < 0 ? vertex + l : lanes[l].neighbor);
  }
}

/// Moves neighbors at one index distance into a contiguous slot, if at least half of the lanes have one.
void add_contiguous(Rows& rows, Batch& batch, int vertex, int padded_count) {
  std::map<int, int> counts;  // number of lanes by index distance
  for (int l = 0; l < kLanes; l++)
    for (const Half& h : batch[std::size_t(l)]) counts[h.neighbor - vertex - l]++;
  for (const auto& [distance, lanes] : counts) {
    const int first = vertex + distance;
    if (lanes < kLanes / 2 || first < 0 || first + kLanes > padded_count) continue;
    Half slot[kLanes];
    for (int l = 0; l < kLanes; l++) {
      auto& row = batch[std::size_t(l)];
      const auto h = std::find_if(row.begin(), row.end(), [&](Half a) { return a.neighbor == first + l; });
      if (h == row.end()) continue;
      slot[l] = *h;
      row.erase(h);
    }
    add_slot(rows, slot, first, vertex);
  }
}

void add_gathered(Rows& rows, const Batch& batch, int vertex) {
  std::size_t slots = 0;
  for (const auto& row : batch) slots = std::max(slots, row.size());
  for (std::size_t s = 0; s < slots; s++) {
    Half slot[kLanes];
    for (int l = 0; l < kLanes; l++)
      if (s < batch[std::size_t(l)].size()) slot[l] = batch[std::size_t(l)][s];
    add_slot(rows, slot, -1, vertex);
  }
}

}  // namespace

Rows make_rows(const std::vector<Spring>& springs, int count) {
  TURGOR_CHECK(std::all_of(springs.begin(), springs.end(),
                           [count](const Spring& s) {
                             return is_index(s.a, std::size_t(count)) && is_index(s.b, std::size_t(count));
                           }),
               "springs join vertices");
  // both ends of every spring
  const int padded_count = int(padded(std::size_t(count)));
  std::vector<std::vector<Half>> halves(std::size_t(padded_count), std::vector<Half>{});
  for (const Spring& s : springs) {
    halves[std::size_t(s.a)].push_back({s.b, s.rest, s.stiffness, s.bend});
    halves[std::size_t(s.b)].push_back({s.a, s.rest, s.stiffness, s.bend});
  }
  // slots of each batch
  Rows rows;
  rows.slot_begin.push_back(0);
  for (int vertex = 0; vertex < padded_count; vertex += kLanes) {
    Batch batch(halves.begin() + vertex, halves.begin() + vertex + kLanes);
    for (auto& row : batch)
      std::sort(row.begin(), row.end(), [](Half a, Half b) { return a.neighbor < b.neighbor; });
    add_contiguous(rows, batch, vertex, padded_count);
    add_gathered(rows, batch, vertex);
    rows.slot_begin.push_back(int(rows.first.size()));
  }
  TURGOR_CHECK(rows.stiffness.size() == rows.first.size() * std::size_t(kLanes),
               "every slot has an entry a lane");
  // unused capacity
  for (auto* list : {&rows.rest, &rows.stiffness, &rows.bend}) list->shrink_to_fit();
  rows.gathered.shrink_to_fit();
  rows.first.shrink_to_fit();
  TURGOR_CHECK(all_indices(rows.gathered, std::size_t(padded_count)), "gathered neighbors are vertices");
  return rows;
}

}  // namespace turgor::cloth
