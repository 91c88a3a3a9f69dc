// The schedule "colours": a sweep is eight passes, one for each parity of (i, j, k). No two nodes of a colour
// are corners of one cell, of one triangle of skin, or of one part of either beside a blade; no two cells of
// a colour share a node. So everything of a pass may be done at once and in any order, and gives the same
// bits. Springs alone would do with four colours, (i + j + k) mod 4; a solid cell joins all eight corners.
// With eight, half a row of the storage has one colour: neighbours in memory are done together by lanes and
// by threads of a GPU, and one rule serves both laws and both solvers.
#pragma once

#include "turgor/core/run.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

constexpr int kColorCount = 8;
/// Of a node; of a cell, by its lowest node.
TURGOR_HD constexpr int color_of(Int3 node) { return (node.x & 1) | (node.y & 1) << 1 | (node.z & 1) << 2; }

struct HalfRow {
  int parity, j, k;  // parity of i
};

/// The half rows of one colour, layer by layer.
struct ColorRows {
  int color, in_layer, layers;

  ColorRows(Int3 size, int of)
      : color(of), in_layer((size.y + 1 - (of >> 1 & 1)) / 2), layers((size.z + 1 - (of >> 2)) / 2) {}

  std::size_t count() const { return std::size_t(in_layer) * std::size_t(layers); }
  HalfRow operator[](std::size_t n) const {
    return {color & 1, 2 * (int(n) % in_layer) + (color >> 1 & 1), 2 * (int(n) / in_layer) + (color >> 2)};
  }
};

/// What is done when, by colour c: entries [begin[c], begin[c + 1]).
struct ColorBegin {
  int begin[kColorCount + 1] = {};
};
/// Appends the first slots of the groups of runs, colour by colour.
ColorBegin groups_by_colors(const Lattice& lattice, const Runs& runs, std::vector<int>& groups);

/// Calls kernel(half_row).
template <class Kernel>
struct OnHalfRow {
  const Kernel& kernel;
  ColorRows rows;

  void operator()(std::size_t n) const { kernel(rows[n]); }
};

/// One pass. A layer's half rows stay on one thread: vectors at the end of a row read, though they do not use
/// it, what lies behind it, which may be a row that is done at the same time.
template <class Run, class Kernel>
void run_half_rows(const Run& run, Int3 size, int color, const Kernel& kernel) {
  const ColorRows rows(size, color);
  run(rows.count(), OnHalfRow<Kernel>{kernel, rows}, std::size_t(rows.in_layer));
}

/// What sweep_pbd and sweep_descent do if the parameters ask for colours, by any run.
template <class Run>
void sweep_pbd_by_colors(const Run& run, const Model& model, State& state);
template <class Run>
void sweep_vbd_by_colors(const Run& run, const Model& model, State& state, const Inputs& inputs, double dt,
                         Order order = Order::kForward);

}  // namespace turgor::lattice
