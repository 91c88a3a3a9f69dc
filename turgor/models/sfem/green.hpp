// Reading the stored Green's functions: blocks of Ξ between kept vertices, from a dense store of either
// precision or from columns that were fetched on demand. Making and checking a store is in sfem.hpp.
#pragma once

#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// True when the column of this stored node is available.
inline bool has_column(const Green& green, int slot) {
  return !green.single_values.empty() || !green.double_values.empty() ||
         (!green.columns.empty() && !green.columns[std::size_t(slot)].empty());
}

/// Block of Ξ: three components of displacement at one stored node for each of three unit forces at another,
/// column-major [m/N]. With columns on demand, the column of one of the two must be available.
inline void green_block(const Green& green, int slot_row, int slot_column, std::span<double, 9> block) {
  TURGOR_CHECK(is_index(slot_row, green.nodes.size()) && is_index(slot_column, green.nodes.size()),
               "Green's functions are read at kept nodes");
  const std::size_t rows = 3 * green.nodes.size(), r = 3 * std::size_t(slot_row),
                    c = 3 * std::size_t(slot_column);
  const auto read = [&](const auto& values, std::size_t first) {
    for (std::size_t j = 0; j < 3; j++)
      for (std::size_t i = 0; i < 3; i++) block[3 * j + i] = double(values[first + j * rows + i]);
  };
  if (!green.single_values.empty()) return read(green.single_values, c * rows + r);
  if (!green.double_values.empty()) return read(green.double_values, c * rows + r);
  // If both columns are available, always the same one is read, so that the result is exactly symmetric.
  const bool swap =
      !has_column(green, slot_column) || (slot_row < slot_column && has_column(green, slot_row));
  const std::vector<float>& column = green.columns[std::size_t(swap ? slot_row : slot_column)];
  TURGOR_ASSERT(!column.empty(), "a block of Green's functions is read before its column is fetched");
  if (!swap) return read(column, r);
  for (std::size_t j = 0; j < 3; j++)
    for (std::size_t i = 0; i < 3; i++) block[3 * j + i] = double(column[i * rows + c + j]);
}

/// Ξ between vertices, 3k×3k, column-major; fixed vertices have zero rows and columns. The others must be
/// kept.
inline void gather_green(const Model& model, std::span<const int> vertices, double* out) {
  const std::size_t n = 3 * vertices.size();
  for (std::size_t b = 0; b < vertices.size(); b++)
    for (std::size_t a = 0; a < vertices.size(); a++) {
      std::array<double, 9> block{};
      const std::size_t row = std::size_t(vertices[a]), column = std::size_t(vertices[b]);
      if (model.free_node[row] >= 0 && model.free_node[column] >= 0) {
        TURGOR_ASSERT(model.green.slot[row] >= 0 && model.green.slot[column] >= 0,
                      "Green's functions are read at a vertex that is not kept");
        green_block(model.green, model.green.slot[row], model.green.slot[column], block);
      }
      for (std::size_t i = 0; i < 9; i++) out[(3 * b + i / 3) * n + 3 * a + i % 3] = block[i];
    }
}

/// Columns on demand that are computed but not yet among the model's.
struct FetchedColumns {
  std::vector<int> slots;
  std::vector<std::vector<float>> values;
};
/// Those of these kept vertices that the model does not have. Reads the model only: a thread beside the ticks
/// may fetch ahead. The model has a factor.
FetchedColumns compute_columns(const Exec& exec, const Model& model, std::span<const int> vertices);
/// Adds the columns to the model, between two ticks.
void add_columns(Green& green, FetchedColumns fetched);

/// Memory of columns on demand [bytes].
std::size_t column_bytes(const Green& green);
/// Removes columns on demand, except those of these vertices, ascending. Not beside a reader of the store.
void keep_columns(Green& green, std::span<const int> vertices);

/// Columns of Ξ over all free nodes, recomputed from the factor: three for each vertex, numbered as K's rows.
CheckColumns full_columns(const Model& model, std::span<const int> vertices);
/// Checksum of a dense store and its check columns.
std::uint64_t checksum(const Green& green);
/// Recomputes `count` random columns from the factor. Error: one is not K's inverse to 1e-6, or differs from
/// the dense store by more than its precision.
Status verify_green(const Model& model, int count, std::uint64_t seed);

}  // namespace turgor::sfem
