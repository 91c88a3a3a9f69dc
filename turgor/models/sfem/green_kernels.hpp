// Columns of K⁻¹ side by side, as loops over plain pointers: a thread a few entries of one column. The same
// source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU solve_units() is faster and means the
// same. Blocks of D are inverted beforehand, so that all is products.
#pragma once

#include "turgor/core/vec.hpp"
#include "turgor/models/sfem/elimination.hpp"

namespace turgor::sfem {

/// So many rows of a supernode are done together, beginning with `first` of its own unknowns or of those
/// below.
struct RowTile {
  static constexpr int kRows = 4;
  int supernode = 0, first = 0;
};

/// Many columns, row-major by place of elimination, and the factor that makes them.
struct ColumnsView {
  const Supernode* supernodes;
  const int* rows;       // Elimination::rows
  const double* values;  // Cholesky::values, with inverses of D's blocks in place of their factors
  double *forces, *x;    // as they go up the tree; K⁻¹ of them [m/N]
  std::size_t columns;

  /// Of place and axis.
  TURGOR_HD std::size_t at(int place, std::size_t unknown, std::size_t column) const {
    return (3 * std::size_t(place) + unknown) * columns + column;
  }
};

/// Unit forces along the axes at these places, beside each other.
struct SetUnits {
  ColumnsView v;
  const int* places;
  TURGOR_HD void operator()(std::size_t c) const { v.forces[v.at(places[c / 3], c % 3, c)] = 1; }
};

/// Up the tree: what a supernode's forces leave for the rows below it.
struct SolveUp {
  ColumnsView v;
  const RowTile* tiles;

  TURGOR_HD void operator()(std::size_t n) const {
    const RowTile tile = tiles[n / v.columns];
    const std::size_t c = n % v.columns;
    const Supernode& s = v.supernodes[tile.supernode];
    const std::size_t width = 3 * std::size_t(s.count), height = 3 * s.row_count, first = tile.first;
    const double* panel = v.values + s.value_begin + width + first;
    double sum[RowTile::kRows] = {};
    for (std::size_t k = 0; k < width; k++) {
      const double force = v.forces[v.at(s.first, k, c)];
      for (int i = 0; i < RowTile::kRows; i++) sum[i] += panel[k * (width + height) + i] * force;
    }
    for (std::size_t i = 0; i < RowTile::kRows && first + i < height; i++)
      v.forces[v.at(v.rows[s.row_begin + (first + i) / 3], (first + i) % 3, c)] -= sum[i];
  }
};

/// Down the tree: a supernode's own rows, from those below it, which are known.
struct SolveDown {
  ColumnsView v;
  const RowTile* tiles;
  const unsigned char* on_path;  // by supernode: 0 = no force has come there

  TURGOR_HD void operator()(std::size_t n) const {
    const RowTile tile = tiles[n / v.columns];
    const std::size_t c = n % v.columns;
    const Supernode& s = v.supernodes[tile.supernode];
    const std::size_t width = 3 * std::size_t(s.count), height = 3 * s.row_count, first = tile.first;
    const double* panel = v.values + s.value_begin;
    std::size_t column[RowTile::kRows];
    double sum[RowTile::kRows] = {};
    for (std::size_t i = 0; i < RowTile::kRows; i++)
      column[i] = (first + i < width ? first + i : width - 1) * (width + height);
    if (on_path[tile.supernode])
      for (std::size_t k = 0; k < width; k++) {
        const double force = v.forces[v.at(s.first, k, c)];
        for (int i = 0; i < RowTile::kRows; i++) sum[i] += panel[column[i] + k] * force;
      }
    for (std::size_t r = 0; r < height; r++) {
      const double x = v.x[v.at(v.rows[s.row_begin + r / 3], r % 3, c)];
      for (int i = 0; i < RowTile::kRows; i++) sum[i] -= panel[column[i] + width + r] * x;
    }
    for (std::size_t i = 0; i < RowTile::kRows && first + i < width; i++)
      v.x[v.at(s.first, first + i, c)] = sum[i];
  }
};

/// The store: column-major, three rows and columns a kept node.
template <class T>
struct StoreView {
  T* values;
  std::size_t side;
  const int* place;  // of each kept node

  TURGOR_HD T& at(std::size_t row, std::size_t column) const { return values[column * side + row]; }
};

/// Copies solved columns of these kept nodes from their own places on, each entry of a node's own block from
/// its lower half.
template <class T>
struct StoreColumns {
  ColumnsView v;
  StoreView<T> store;
  const int* slots;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t row = n / v.columns, c = n % v.columns, node = row / 3, i = row % 3, j = c % 3;
    const auto slot = std::size_t(slots[c / 3]);
    if (store.place[node] < store.place[slot]) return;
    const bool swap = node == slot && i < j;
    store.at(row, 3 * slot + j) = T(v.x[v.at(store.place[node], swap ? j : i, c - j + (swap ? i : j))]);
  }
};

/// Fills the half that was not solved.
template <class T>
struct MirrorStore {
  StoreView<T> store;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t row = n % store.side, column = n / store.side;
    if (store.place[row / 3] < store.place[column / 3]) store.at(row, column) = store.at(column, row);
  }
};

struct ClearForces {
  double* forces;
  TURGOR_HD void operator()(std::size_t n) const { forces[n] = 0; }
};

}  // namespace turgor::sfem
