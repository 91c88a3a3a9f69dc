#include "turgor/models/lattice/cutting/cut_fraction.hpp"

#include <algorithm>
#include <bit>
#include <optional>

#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {

namespace {

bool comes_before(const CutFractionSamples& a, const CutFractionSamples& b) {
  return a.slot != b.slot ? a.slot < b.slot : a.incision < b.incision;
}

/// Where a plane crosses a line of a cell, between two of its faces.
std::optional<Vec3d> meet(int axis, int line, const CrackTipPlane& plane, Vec3d corner) {
  Vec3d from = line_start(axis, line), to = from;
  to[axis] = 1;
  const double a = plane.at(corner + from), b = plane.at(corner + to);
  if ((a >= 0) == (b >= 0)) return {};
  from[axis] = a / (a - b);
  return from;
}

}  // namespace

void mark_cut_samples(const Model& model, State& state, const BladePath& path, double begin, double end,
                      int incision) {
  std::vector<CutFractionSamples> now;
  for (const PendingSampleCut& line : path.lines) {
    if (double(line.along) < begin || double(line.along) >= end) continue;
    if (now.empty() || now.back().slot != line.slot)
      now.push_back({.slot = line.slot, .incision = std::uint8_t(incision)});
    now.back().lines[line.axis] |= std::uint64_t(1) << line.line;
  }
  for (const CutFractionSamples& cell : now) {
    auto at = std::lower_bound(state.cut_samples.begin(), state.cut_samples.end(), cell, comes_before);
    if (at == state.cut_samples.end() || comes_before(cell, *at))
      at = state.cut_samples.insert(at, {.slot = cell.slot, .incision = cell.incision});
    int count = 0;
    for (std::size_t axis = 0; axis < 3; axis++) {
      count += std::popcount(cell.lines[axis] & ~at->lines[axis]);
      at->lines[axis] |= cell.lines[axis];
    }
    state.cut_sample_count += count;
    if (count > 0) wake_around(model, state, cell.slot, 2), state.sleep.coarse_still = 0;
  }
}

double cut_fraction(const State& state, const Fragments& pieces, const CutCell& cell, const CrackTip& tip) {
  const CutFractionSamples wanted{.slot = cell.slot, .incision = tip.incision};
  const auto at = std::lower_bound(state.cut_samples.begin(), state.cut_samples.end(), wanted, comes_before);
  if (at == state.cut_samples.end() || comes_before(wanted, *at)) return 0;
  const Vec3d corner(in_body(pieces.fine.cells, slot_node(pieces.fine.cells, cell.slot)));
  int all = 0, cut_samples = 0;
  for (int axis = 0; axis < 3; axis++) {
    int of = 0, count = 0;
    for (int line = 0; line < kLines; line++) {
      const std::optional<Vec3d> met = meet(axis, line, tip.plane, corner);
      if (!met) continue;
      const int piece = fragment_at(pieces, state, cell, Vec3(*met));
      if (piece != tip.left && piece != tip.right) continue;
      of++, count += int(at->lines[std::size_t(axis)] >> line & 1);
    }
    if (of > all) all = of, cut_samples = count;
  }
  return all > 0 ? double(cut_samples) / all : 0;
}

}  // namespace turgor::lattice
