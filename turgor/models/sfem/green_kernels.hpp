// Kernels for columns of K⁻¹ over plain pointers; a thread computes a few entries of one column. The same
// source runs on a CPU (CpuRun, ShuffledRun) and on a GPU. On a CPU solve_units() is faster and equivalent.
// Blocks of D are inverted in advance, so that all operations are products.
#pragma once

#include "turgor/core/vec.hpp"
#include "turgor/models/sfem/elimination.hpp"

namespace turgor::sfem {

/// A tile of rows of a supernode, beginning with `first` of its own unknowns or of those below, processed
/// together.
struct RowTile {
  static constexpr int kRows = 4;
  int supernode = 0, first = 0;
};

/// Many columns, row-major by position in the elimination order, and the factor that computes them.
struct ColumnsView {
  const Supernode* supernodes;
  const int* rows;       // Elimination::rows
  const double* values;  // Cholesky::values, with D's blocks replaced by their inverses
  double *forces, *x;    // as they go up the tree; K⁻¹ of them [m/N]
  std::size_t columns;

  /// Index of a position, axis and column.
  TURGOR_HD std::size_t at(int position, std::size_t unknown, std::size_t column) const {
    return (3 * std::size_t(position) + unknown) * columns + column;
  }
};

/// Sets unit forces along the axes at these positions, one a column.
struct SetUnits {
  ColumnsView v;
  const int* positions;
  TURGOR_HD void operator()(std::size_t c) const { v.forces[v.at(positions[c / 3], c % 3, c)] = 1; }
};

/// Forward substitution: contribution of a supernode's forces to the rows below it.
struct SolveUp {
  ColumnsView v;
  const RowTile* tiles;

  TURGOR_HD void operator()(std::size_t n) const {
    // a tile of rows and one column
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

/// Backward substitution: a supernode's own rows from those below it, which are known.
struct SolveDown {
  ColumnsView v;
  const RowTile* tiles;
  const unsigned char* on_path;  // by supernode: 0 = not on the path of a force

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
  const int* position;  // of each kept node

  TURGOR_HD T& at(std::size_t row, std::size_t column) const { return values[column * side + row]; }
};

/// Copies solved columns of these stored nodes from their own positions on. Each node's own block is taken
/// from its lower half.
template <class T>
struct StoreColumns {
  ColumnsView v;
  StoreView<T> store;
  const int* slots;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t row = n / v.columns, c = n % v.columns, node = row / 3, i = row % 3, j = c % 3;
    const auto slot = std::size_t(slots[c / 3]);
    if (store.position[node] < store.position[slot]) return;
    const bool swap = node == slot && i < j;
    store.at(row, 3 * slot + j) = T(v.x[v.at(store.position[node], swap ? j : i, c - j + (swap ? i : j))]);
  }
};

/// Mirrors the solved half.
template <class T>
struct MirrorStore {
  StoreView<T> store;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::size_t row = n % store.side, column = n / store.side;
    if (store.position[row / 3] < store.position[column / 3]) store.at(row, column) = store.at(column, row);
  }
};

struct ClearForces {
  double* forces;
  TURGOR_HD void operator()(std::size_t n) const { forces[n] = 0; }
};

}  // namespace turgor::sfem
