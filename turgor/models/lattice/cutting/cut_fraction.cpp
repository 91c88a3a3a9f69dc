#include "turgor/models/lattice/cutting/cut_fraction.hpp"

#include <algorithm>
#include <bit>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {

namespace {

bool comes_before(const CutFractionSamples& a, const CutFractionSamples& b) {
  return a.slot != b.slot ? a.slot < b.slot : a.incision < b.incision;
}

/// Intersection of a plane with a sample line, inside the cell.
std::optional<Vec3d> meet(int axis, int line, const CrackTipPlane& plane, Vec3d corner) {
  Vec3d from = line_start(axis, line), to = from;
  to[axis] = 1;
  const double a = plane.signed_distance(corner + from), b = plane.signed_distance(corner + to);
  if ((a >= 0) == (b >= 0)) return {};
  from[axis] = a / (a - b);
  return from;
}

}  // namespace

void mark_cut_samples(const Model& model, State& state, const BladePath& path, double begin, double end,
                      int incision) {
  // newly crossed sample lines, by cell
  TURGOR_ASSERT(is_index(incision, 256), "the index of an incision is below 256");
  std::vector<CutFractionSamples> now;
  for (const PendingSampleCut& line : path.lines) {
    if (double(line.along) < begin || double(line.along) >= end) continue;
    if (now.empty() || now.back().slot != line.slot)
      now.push_back({.slot = line.slot, .incision = std::uint8_t(incision)});
    now.back().lines[line.axis] |= std::uint64_t(1) << line.line;
  }
  TURGOR_CHECK(std::is_sorted(state.cuts.samples.begin(), state.cuts.samples.end(), comes_before),
               "cut samples ascend by cell and incision");
  // merge them into the state, and wake the rows around
  for (const CutFractionSamples& cell : now) {
    auto at = std::lower_bound(state.cuts.samples.begin(), state.cuts.samples.end(), cell, comes_before);
    if (at == state.cuts.samples.end() || comes_before(cell, *at))
      at = state.cuts.samples.insert(at, {.slot = cell.slot, .incision = cell.incision});
    int count = 0;
    for (std::size_t axis = 0; axis < 3; axis++) {
      count += std::popcount(cell.lines[axis] & ~at->lines[axis]);
      at->lines[axis] |= cell.lines[axis];
    }
    state.cuts.sample_count += count;
    if (count > 0) wake_around(model, state, cell.slot, 2), state.sleep.coarse_still_steps = 0;
  }
}

bool is_sampled(const Cuts& cuts, int slot, std::uint8_t incision) {
  return std::binary_search(cuts.samples.begin(), cuts.samples.end(),
                            CutFractionSamples{.slot = slot, .incision = incision}, comes_before);
}

int sampled_incisions(const Cuts& cuts, int slot) {
  const auto by_slot = [](const CutFractionSamples& a, const CutFractionSamples& b) {
    return a.slot < b.slot;
  };
  const auto [begin, end] =
      std::equal_range(cuts.samples.begin(), cuts.samples.end(), CutFractionSamples{.slot = slot}, by_slot);
  return int(end - begin);
}

double cut_fraction(const Cuts& cuts, const Fragments& fragments, const CutCell& cell,
                    // samples of this cell and incision
                    const CrackTip& tip) {
  TURGOR_CHECK(is_index(tip.left, std::size_t(cell.fragment_count)) &&
                   is_index(tip.right, std::size_t(cell.fragment_count)),
               "a crack tip splits two fragments of its cell");
  const CutFractionSamples wanted{.slot = cell.slot, .incision = tip.incision};
  const auto at = std::lower_bound(cuts.samples.begin(), cuts.samples.end(), wanted, comes_before);
  if (at == cuts.samples.end() || comes_before(wanted, *at)) return 0;
  // crossed fraction of the lines that pass from one fragment to the other; the axis with most such lines is
  // used
  const Vec3d corner(in_body(fragments.fine.cells, slot_node(fragments.fine.cells, cell.slot)));
  int all = 0, cut_samples = 0;
  for (int axis = 0; axis < 3; axis++) {
    int valid = 0, count = 0;
    for (int line = 0; line < kLines; line++) {
      const std::optional<Vec3d> met = meet(axis, line, tip.plane, corner);
      if (!met) continue;
      const int fragment = fragment_at(fragments, cuts, cell, Vec3(*met));
      if (fragment != tip.left && fragment != tip.right) continue;
      valid++, count += int(at->lines[std::size_t(axis)] >> line & 1);
    }
    if (valid > all) all = valid, cut_samples = count;
  }
  TURGOR_CHECK(cut_samples <= all, "a cut fraction is at most one");
  return all > 0 ? double(cut_samples) / all : 0;
}

}  // namespace turgor::lattice
