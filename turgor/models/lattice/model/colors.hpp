// Coloring of the lattice: a sweep is eight passes, one per parity of (i, j, k). No two nodes of a color are
// corners of one cell, one skin triangle or one cut element. No two cells of a color share a node. All work
// of a pass can run at once and in any order, with the same bits. Springs alone need only four colors, (i + j
// + k) mod 4; a solid cell couples all eight corners. With eight colors a half row has one color: SIMD lanes
// and GPU threads process neighbors in memory together. The same rule serves both tissue laws and both
// solvers.
#pragma once

#include "turgor/core/run.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

constexpr int kColorCount = 8;
/// Color of a node, or of a cell by its lowest node.
TURGOR_HD constexpr int color_of(Int3 node) { return (node.x & 1) | (node.y & 1) << 1 | (node.z & 1) << 2; }

struct HalfRow {
  int parity, j, k;  // parity of i
};

/// Half rows of one color, layer by layer.
struct ColorRows {
  int color, in_layer, layers;

  ColorRows(Int3 size, int of)
      : color(of), in_layer((size.y + 1 - (of >> 1 & 1)) / 2), layers((size.z + 1 - (of >> 2)) / 2) {}

  std::size_t count() const { return std::size_t(in_layer) * std::size_t(layers); }
  HalfRow operator[](std::size_t n) const {
    return {color & 1, 2 * (int(n) % in_layer) + (color >> 1 & 1), 2 * (int(n) / in_layer) + (color >> 2)};
  }
};

/// Ranges by color: color c has entries [begin[c], begin[c + 1]).
struct ColorBegin {
  int begin[kColorCount + 1] = {};
};
/// Appends the first slot of each group of the runs, color by color.
ColorBegin groups_by_colors(const Lattice& lattice, const Runs& runs, std::vector<int>& groups);

/// Calls kernel(half_row).
template <class Kernel>
struct OnHalfRow {
  const Kernel& kernel;
  ColorRows rows;

  void operator()(std::size_t n) const { kernel(rows[n]); }
};

/// One pass. Half rows of a layer stay on one thread: full vectors at the end of a row read (but do not use)
/// the slots behind it, and these may belong to a row of the same pass.
template <class Run, class Kernel>
void run_half_rows(const Run& run, Int3 size, int color, const Kernel& kernel) {
  const ColorRows rows(size, color);
  run(rows.count(), OnHalfRow<Kernel>{kernel, rows}, std::size_t(rows.in_layer));
}

}  // namespace turgor::lattice
